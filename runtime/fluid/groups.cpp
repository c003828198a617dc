// Groups of pools that take their fluid substeps together: pools of a solver that iterates are connected where a body
// that the fluid moves lies within the support of both, so that its motion by one reaches the other within the substep.
// Others run their own loops, one after another: the most demanding pool does not set the cost of all. Connections are
// found by boxes swept over the coming substep. Pools of the explicit solver are each a group. Kept between calls:
// nothing. Weak spot: boxes; a pool with spray all over the scene is near everything.
#include <algorithm>
#include <cmath>

#include "fluid/block_sums.h"
#include "fluid/impl.h"

namespace feder {
namespace {

// Bounds of a solid then.
Aabb swept_bounds(const BoundaryShape& w, const BoundaryBody& b, Real h) {
  Aabb box = w.box;
  box.grow(h * (length(b.velocity) + w.rim_speed(b)));
  return box;
}

// Root of pool k, the first of its group; while groups grow, `group` counts within the solver's pools.
std::uint32_t first_of(const std::vector<FluidPool*>& pools, std::uint32_t k) {
  while (pools[k]->group != k) k = pools[k]->group;
  return k;
}

}  // namespace

Aabb swept_bounds(const FluidPool& p, const StepContext& c) {
  struct Extremes {
    Aabb box;
    Real speed2 = 0;
    void add(const Extremes& e) { box.include(e.box), speed2 = std::max(speed2, e.speed2); }
  };
  Extremes all = sum_blocks<Extremes>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Extremes& e) {
    e.box.include(p.x[i].vec());
    e.speed2 = std::max(e.speed2, dot(p.v[i].vec(), p.v[i].vec()));
  });
  all.box.grow(p.support + c.h * (std::sqrt(all.speed2) + c.h * length(c.gravity)));
  return all.box;
}

void Fluid::Impl::join_pools(const std::vector<FluidPool*>& members, StepContext& c) {
  swept.clear();
  for (const FluidPool* p : members) swept.push_back(swept_bounds(*p, c));
  for (std::uint32_t b = 0; b < boundary.bodies.size(); ++b) {
    if (!boundary.bodies[b].dynamic) continue;
    std::uint32_t first = kNone;
    for (const BoundaryShape& w : boundary.shapes) {
      if (w.body != b) continue;
      const Aabb box = swept_bounds(w, boundary.bodies[b], c.h);
      for (std::uint32_t k = 0; k < members.size(); ++k) {
        if (members[k]->count == 0 || members[k]->mixed || !members[k]->meets(w) || !overlaps(swept[k], box)) continue;
        const std::uint32_t one = first_of(members, k), other = first == kNone ? one : first_of(members, first);
        members[std::max(one, other)]->group = std::min(one, other);
        first = std::min(one, other);
      }
    }
  }
}

void Fluid::Impl::begin_substep(StepContext& c) {
  if (c.substep == 0) {
    for (auto& p : pools) p->worked = 0;
    wake_disturbed(c);
  }
  boundary.start();
}

void Fluid::Impl::make_groups(StepContext& c) {
  std::vector<int>& counts = c.counts(Loop::fluid).count;
  counts.clear();
  if (!mixtures.empty()) mix(c);
  for (auto& s : solvers) {
    if (!s) continue;
    const std::vector<FluidPool*>& members = s->pools;
    for (std::uint32_t k = 0; k < members.size(); ++k) members[k]->group = k;
    if (s->iterates() && members.size() > 1) join_pools(members, c);
    // indices within the solver become those of the loop; the first of a group comes before its other members
    group_number.resize(members.size());
    for (std::uint32_t k = 0; k < members.size(); ++k) {
      const std::uint32_t first = first_of(members, k);
      FEDER_ASSERT(first <= k);
      if (first == k)
        group_number[k] = static_cast<std::uint32_t>(counts.size()), counts.push_back(0);
      else
        group_number[k] = group_number[first];
    }
    for (std::uint32_t k = 0; k < members.size(); ++k) members[k]->group = group_number[k];
  }
}

}  // namespace feder
