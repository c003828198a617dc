// Joints that stay open. Stiff rows may give way for some steps in an impact; what is found open at two looks in a row,
// kGapSteps apart, gives way under its load. Warns once per world, with the worst of the joints looked at in that step.
// Not of what a script moved in the last second: that closes. Kept between steps: the count in JointRecord. Weak spot:
// a joint that opens and closes faster than two looks says nothing.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "constrain/frames.h"
#include "rigid/impl.h"
#include "step/watch.h"

namespace feder {
namespace {

constexpr std::uint64_t kGapSteps = 32;  // between two looks at a joint
constexpr std::uint8_t kGapLooks = 2;    // in a row
constexpr Real kOpens = Real(0.1);       // of the radius of the smaller body
constexpr Real kBends = Real(0.3);       // rad

}  // namespace

// How far joint j is open (m) and bent (rad): its stiff equalities.
JointGap Rigid::Impl::gap_of(std::uint32_t j) const {
  JointGap gap;
  const JointInput in = joint_input(j);
  if (joints[j].kind->wide == WideRows::point) {
    gap.open = length(world_anchors(in).gap);
    return gap;
  }
  fill_rows(j, in);
  for (const Row& row : rows) {
    if (row.velocity_only || row.hertz > 0 || row.lower != -kInfinity || row.upper != kInfinity) continue;
    (row.linear.isZero(0) ? gap.bend : gap.open) += row.value * row.value;
  }
  gap.open = std::sqrt(gap.open), gap.bend = std::sqrt(gap.bend);
  return gap;
}

// Of the smaller of its bodies that move.
Real Rigid::Impl::radius_of(const JointRecord& r) const {
  Real radius = kInfinity;
  for (const std::uint32_t i : {r.body_a, r.body_b})
    if (bodies.moves(i)) radius = std::min(radius, bodies.extent[i]);
  return radius;
}

void Rigid::Impl::check_open_joints(StepContext& c) {
  const auto window = static_cast<std::uint64_t>(kScriptWindow / static_cast<double>(c.dt)) + 1;
  std::uint32_t worst = kNone;
  JointGap widest;
  Real most = 1;
  for (std::size_t n = c.step % kGapSteps; n < active_joints.size(); n += kGapSteps) {
    const std::uint32_t j = active_joints[n];
    JointRecord& r = records[j];
    if (!r.alive || !joints[j].active) continue;  // broke in this step
    bool edited = false;
    for (const std::uint32_t i : {r.body_a, r.body_b})
      edited = edited || (i != kNone && c.step < edited_step[i] + window);
    const JointGap gap = gap_of(j);
    const Real share = std::max(gap.open / (kOpens * radius_of(r)), gap.bend / kBends);
    if (edited || !(share > 1)) {
      r.open_looks = 0;
      continue;
    }
    if (r.open_looks < kGapLooks) ++r.open_looks;
    if (r.open_looks < kGapLooks || share <= most) continue;
    worst = j, widest = gap, most = share;
  }
  if (worst == kNone) return;
  gap_warned = true;
  const JointRecord& r = records[worst];
  const auto end = [&](ObjectId body) {
    return body == ObjectId{} ? std::string("the world") : objects.describe(body);
  };
  const bool opens = widest.open / (kOpens * radius_of(r)) > widest.bend / kBends;
  char text[160];
  std::snprintf(text, sizeof text,
                opens ? " stays open by %.2g m: more substeps than %d, or masses that differ less, would hold it"
                      : " stays bent by %.2g rad: more substeps than %d, or masses that differ less, would hold it",
                static_cast<double>(opens ? widest.open : widest.bend), c.substeps);
  events.warn("open_joint", objects.describe(r.object) + " of " + end(r.a) + " and " + end(r.b) + text, r.object);
}

}  // namespace feder
