// Point joints of the soft-step solver, eight at a time (joint_batch.h). Joints are coloured greedily in the order of
// their indices: no two of a colour push the same solver body, so that eight lanes and several threads give the same
// bits as one. Solvers hand over joints by what their kinds say of them (WideRows), never by kind.
#pragma once
#include "base/jobs.h"
#include "rigid/joint_batch.h"
#include "rigid/solver.h"

namespace feder {

class WideJoints {
 public:
  WideJoints(Arena& arena, const JointKernels& kernels) : kernels_(&kernels), lanes_(&arena), batches_(&arena) {}

  bool empty() const { return batches_.empty(); }
  void clear() { lanes_.clear(), batches_.clear(); }
  // Colours the joints of `wanted` (ascending); those that find no colour are left to `rest`.
  void color(const SolverInput& in, std::span<const std::uint32_t> wanted, Array<std::uint32_t>& rest, StepContext& c);

  // Once per step: anchors, masses and impulses into the batches. `in_contact`: by solver index. Adds the strain of
  // the impulses to `strain`, by solver index.
  void load(const SolverInput& in, StepContext& c, std::span<const std::uint8_t> in_contact, std::span<Real> strain);
  // Each substep: rows at the poses now, warm start, and the biased pass.
  void solve(const JointPass& pass, StepContext& c);
  void relax(const JointPass& pass, StepContext& c);        // colours in reverse
  void note_loads(const SolverInput& in, Real h) const;     // of joints that can break, after a substep
  void store(const SolverInput& in, StepContext& c) const;  // once per step: impulses back

 private:
  using Kernel = void (*)(const JointPass&);
  static constexpr int kColors = 64;

  void fill(const SolverInput& in, std::uint32_t batch, std::span<const std::uint8_t> in_contact);
  void fill_lane(const SolverInput& in, const SolverJoint& joint, PointJointBatch& c, int lane);
  void check_colors(const SolverInput& in, StepContext& c) const;

  const JointKernels* kernels_;
  Array<std::uint32_t> lanes_;  // joint by batch and lane, kNone where empty
  Array<PointJointBatch> batches_;
  std::uint32_t color_first_[kColors + 1] = {};  // first batch of each colour
  JobPool::Stage stages_[2 * kColors + 1];
};

// The kernels for this processor.
const JointKernels& joint_kernels(bool wide);

}  // namespace feder
