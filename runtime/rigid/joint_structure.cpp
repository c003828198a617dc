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

// Joints of a step, up to kKeyGrain.items of them: what the order of a solve depends on.
SequenceHash SoftJoints::hash_of(const SolverInput& in, std::span<const std::uint32_t> list) const {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  SequenceHash hash;
  for (const std::uint32_t j : list) {
    const SolverJoint& joint = in.joints[j];
    const JointOptions& o = joint.shape.options;
    const std::uint64_t a = solver_bodies.at(joint.slot_a), b = solver_bodies.at(joint.slot_b);
    const unsigned sides = sides_of(in, joint) | unsigned(o.has_limits) << 4 | unsigned(o.has_motor) << 5;
    hash.add(std::uint64_t(j) << 32 | a, b << 32 | sides, word_of(joint.kind), word_of(o.lower), word_of(o.upper),
             word_of(o.motor_max), word_of(o.spring_hertz), word_of(o.rest_length));
  }
  return hash;
}

// Bits: which sides move, which are uneven.
unsigned SoftJoints::sides_of(const SolverInput& in, const SolverJoint& joint) const {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  const std::uint32_t a = solver_bodies.at(joint.slot_a), b = solver_bodies.at(joint.slot_b);
  return unsigned(solver_bodies.mass[a].inv_mass > 0) | unsigned(solver_bodies.mass[b].inv_mass > 0) << 1 |
         unsigned(in.uneven(a) != nullptr) << 2 | unsigned(in.uneven(b) != nullptr) << 3;
}

// Compares hashes with those of the last step, and replaces them.
bool SoftJoints::structure_changed(const SolverInput& in, StepContext& c) {
  const auto count = static_cast<std::uint32_t>(in.active_joints.size());
  bool changed = key_count_ != count || norm_.size() != in.solver_bodies->state.size();
  const std::uint32_t blocks = (count + kKeyGrain.items - 1) / kKeyGrain.items;
  key_count_ = count;
  keys_.resize(blocks);
  std::uint8_t* differs = c.scratch->take<std::uint8_t>(blocks);
  c.jobs->for_blocks(count, kKeyGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    const SequenceHash hash = hash_of(in, in.active_joints.subspan(first, last - first));
    SequenceHash& key = keys_[first / kKeyGrain.items];
    differs[first / kKeyGrain.items] = key != hash;
    key = hash;
  });
  for (std::uint32_t k = 0; k < blocks; ++k) changed = changed || differs[k];
  return changed;
}

void SoftJoints::list_bodies(const SolverInput& in) {
  const std::size_t count = in.solver_bodies->state.size();
  marks_.assign(count, 0);
  for (const std::uint32_t j : in.active_joints)
    for (const std::uint32_t slot : {in.joints[j].slot_a, in.joints[j].slot_b}) marks_[in.solver_bodies->at(slot)] = 1;
  bodies_.clear();
  bodies_.reserve(count);
  for (std::uint32_t i = 1; i < count; ++i)
    if (marks_[i]) bodies_.push_back(i);
  // of all others nothing is read but for the world's
  strain_.assign(count, Real(0));
  strain_axes_.assign(uneven_ ? count : 0, Vec3d::Zero());
  norm_.assign(count, Real(0));
  share_.assign(count, Real(1));
  smooth_.assign(count, Real(1));
}

// Joints whose kind allows it, of even bodies and in no tree, are solved wide; the others by rows.
void SoftJoints::choose_wide(const SolverInput& in, StepContext& c) {
  candidates_.clear(), narrow_.clear();
  candidates_.reserve(key_count_), narrow_.reserve(key_count_);
  marks_.assign(blocks_.size(), 0);
  std::size_t block = 0;
  for (const std::uint32_t j : in.active_joints) {
    const SolverJoint& joint = in.joints[j];
    const std::size_t first = block;
    bool direct = false;
    for (; block < blocks_.size() && blocks_[block].joint == j; ++block) direct = direct || is_direct(block);
    const bool wide = joint.kind->wide == WideRows::point && !direct && sides_of(in, joint) < 4;
    (wide ? candidates_ : narrow_).push_back(j);
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
  inv_inertia_.assign(narrow_.empty() ? 1 : in.solver_bodies->state.size(), Mat3(Mat3::Zero()));
  fill_rows(in, 0);
  list_bounded();
  all_direct_ = !trees_.empty() && wide_.empty();
  for (std::size_t i = 0; all_direct_ && i < trees_.blocks(); ++i) all_direct_ = trees_.direct(i);
}

}  // namespace feder
