// What the joints of a step look like together: which bodies they join, which are solved as trees, which eight at a
// time and which by rows. Found anew only when the joints or what they join changes.
#include <algorithm>

#include "constrain/joint.h"
#include "feder/error.h"
#include "rigid/soft_joints.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

constexpr JobGrain kKeyGrain{512, 8'000};  // joints per job

}  // namespace

bool SoftJoints::JointKey::operator==(const JointKey& other) const {
  const auto equal = [](const JointOptions& x, const JointOptions& y) {
    return x.lower == y.lower && x.upper == y.upper && x.has_limits == y.has_limits && x.has_motor == y.has_motor &&
           x.motor_max == y.motor_max && x.spring_hertz == y.spring_hertz && x.rest_length == y.rest_length;
  };
  return joint == other.joint && index_a == other.index_a && index_b == other.index_b && bodies == other.bodies &&
         kind == other.kind && equal(options, other.options);
}

SoftJoints::JointKey SoftJoints::key_of(const SolverInput& in, std::uint32_t j) const {
  const SolverJoint& joint = in.joints[j];
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t a = solver_bodies.at(joint.slot_a), b = solver_bodies.at(joint.slot_b);
  const unsigned bits = unsigned(solver_bodies.mass[a].inv_mass > 0) +
                        2 * unsigned(solver_bodies.mass[b].inv_mass > 0) + 4 * unsigned(in.uneven(a) != nullptr) +
                        8 * unsigned(in.uneven(b) != nullptr);
  return {j, a, b, bits, joint.kind, joint.shape.options};
}

// Compares keys with those of the last step, and replaces them.
bool SoftJoints::structure_changed(const SolverInput& in, StepContext& c) {
  const auto count = static_cast<std::uint32_t>(in.active_joints.size());
  bool changed = keys_.size() != count || norm_.size() != in.solver_bodies->state.size();
  keys_.resize(count);
  std::uint8_t* differs = c.scratch->take<std::uint8_t>(count / kKeyGrain.items + 1);
  c.jobs->for_blocks(count, kKeyGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    std::uint8_t any = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      const JointKey key = key_of(in, in.active_joints[i]);
      if (keys_[i] == key) continue;
      keys_[i] = key;
      any = 1;
    }
    differs[first / kKeyGrain.items] = any;
  });
  for (std::uint32_t i = 0; i < count; i += kKeyGrain.items) changed = changed || differs[i / kKeyGrain.items];
  return changed;
}

void SoftJoints::list_bodies(const SolverInput& in) {
  const std::size_t count = in.solver_bodies->state.size();
  marks_.assign(count, 0);
  for (const JointKey& key : keys_) marks_[key.index_a] = marks_[key.index_b] = 1;
  bodies_.clear();
  bodies_.reserve(count);
  for (std::uint32_t i = 1; i < count; ++i)
    if (marks_[i]) bodies_.push_back(i);
  // of all others nothing is read but for the world's
  strain_.assign(count, Real(0));
  strain_axes_.assign(count, Vec3d::Zero());
  norm_.assign(count, Real(0));
  share_.assign(count, Real(1));
  smooth_.assign(count, Real(1));
  inv_inertia_.assign(count, Mat3(Mat3::Zero()));
}

// Joints whose kind allows it, of even bodies and in no tree, are solved wide; the others by rows.
void SoftJoints::choose_wide(const SolverInput& in, StepContext& c) {
  candidates_.clear(), narrow_.clear();
  candidates_.reserve(keys_.size()), narrow_.reserve(keys_.size());
  marks_.assign(blocks_.size(), 0);
  std::size_t block = 0;
  for (const JointKey& key : keys_) {
    const std::size_t first = block;
    bool direct = false;
    for (; block < blocks_.size() && blocks_[block].joint == key.joint; ++block) direct = direct || is_direct(block);
    const bool wide = key.kind->wide == WideRows::point && !direct && key.bodies < 4;
    (wide ? candidates_ : narrow_).push_back(key.joint);
    for (std::size_t i = first; i < block; ++i) marks_[i] = wide;
  }
  wide_.color(in, {candidates_.data(), candidates_.size()}, narrow_, c);
  std::sort(narrow_.begin(), narrow_.end());
  // rows are numbered without those of the wide joints
  std::size_t rest = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    while (rest < narrow_.size() && narrow_[rest] < blocks_[i].joint) ++rest;
    marks_[i] = rest == narrow_.size() || narrow_[rest] != blocks_[i].joint;
  }
  trees_.leave_out({marks_.data(), marks_.size()}, {blocks_.data(), blocks_.size()});
}

// Trees, colours, and who is solved how: a function of the keys alone, so that a restored world finds the same.
void SoftJoints::find_structure(const SolverInput& in, StepContext& c) {
  list_bodies(in);
  narrow_.assign(in.active_joints.begin(), in.active_joints.end());
  fill_rows(in, 0);
  trees_.clear();
  if (use_trees_) trees_.find(rows_, blocks_, *in.solver_bodies);
  choose_wide(in, c);
  fill_rows(in, 0);
  list_bounded();
  all_direct_ = !trees_.empty() && wide_.empty();
  for (std::size_t i = 0; all_direct_ && i < trees_.blocks(); ++i) all_direct_ = trees_.direct(i);
}

}  // namespace feder
