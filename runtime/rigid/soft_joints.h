// Joint rows for the soft-step solver: blocks of up to six rows solved together by LDL^T, softened like contacts.
#pragma once
#include "rigid/contact_batch.h"
#include "rigid/joint_trees.h"
#include "rigid/solver.h"

namespace feder {

// Soft row factors for a frequency and damping ratio at substep h (Catto 2011): mass-independent.
SoftFactors soft_factors(Real hertz, Real damping_ratio, Real h);

class SoftJoints {
 public:
  SoftJoints(Arena& arena, Real hertz, Real damping_ratio, bool use_trees)
      : rows_(&arena),
        blocks_(&arena),
        ready_(&arena),
        prepared_(&arena),
        trees_(arena),
        bias_(&arena),
        step_(&arena),
        strain_(&arena),
        hertz_(hertz),
        damping_ratio_(damping_ratio),
        use_trees_(use_trees) {}

  bool empty() const { return blocks_.empty(); }
  // Rows at the poses now, effective masses, and last impulses applied. `change` collects what joints do to each
  // mover's velocity (6 numbers per mover).
  void start(const SolverInput& in, const StepContext& c, Real* change);
  void clear() { rows_.clear(), blocks_.clear(), trees_.clear(); }
  void solve(const SolverInput& in, bool biased, Real* change);

 private:
  // A row ready to be iterated.
  struct ReadyRow {
    Vec3 linear, angular_a, angular_b;
    Vec3 push_a, push_b;      // inverse inertia x angular part
    Real bias, relaxed_bias;  // m/s
    Real mass_scale, impulse_scale;
    Real relaxed_mass_scale, relaxed_impulse_scale;
    Real lower, upper;        // of the accumulated impulse, N s
  };
  // Lower triangle of L and the inverse pivots.
  struct ReadyBlock {
    Real factor[15];
    Real inv_pivot[6];
  };
  bool is_direct(std::size_t block) const;
  void stabilize(const SolverInput& in, Real h);
  void prepare_row(const Row& row, const Mat3& inv_inertia_a, const Mat3& inv_inertia_b, Real h, ReadyRow& out) const;
  void prepare_block(const RowBlock& block, const MoverMass& a, const MoverMass& b, ReadyBlock& out) const;
  void apply(const RowBlock& block, const Real* impulse, const SolverInput& in, Real* change) const;
  void solve_trees(const SolverInput& in, bool biased, Real* change);
  void solve_block(std::size_t index, const SolverInput& in, bool biased, Real* change);

  Array<Row> rows_;
  Array<RowBlock> blocks_;
  Array<ReadyRow> ready_;
  Array<ReadyBlock> prepared_;
  JointTrees trees_;
  Array<Real> bias_, step_;  // by row, for the trees
  Array<Real> strain_;       // by mover: h sum |impulse| |arm|, then the factor on the inverse inertia
  Real hertz_, damping_ratio_;
  bool use_trees_;
  Real stiff_hertz_ = 0;
};

}  // namespace feder
