// Joint rows of the soft-step solver: blocks of up to six rows solved together by LDL^T, with soft constraints as for
// contacts. The method is described in soft_joints.cpp.
#pragma once
#include "base/hash.h"
#include "rigid/contact_batch.h"
#include "rigid/joint_trees.h"
#include "rigid/solver.h"
#include "rigid/wide_joints.h"

namespace feder {

// Soft row factors for a frequency and damping ratio at substep h (Catto 2011): mass-independent.
SoftFactors soft_factors(Real hertz, Real damping_ratio, Real h);

// Velocity that only corrects positions (pseudo-velocity) of one solver body.
struct BodySlide {
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // m/s, rad/s
};

class SoftJoints {
 public:
  // `push_speed`, m/s: the largest speed at which an open joint of a loop is closed.
  SoftJoints(Arena& arena, Real hertz, Real damping_ratio, Real push_speed, bool use_trees, const JointKernels& kernels)
      : arena_(arena), wide_(arena, kernels), hertz_(hertz), damping_ratio_(damping_ratio), push_speed_(push_speed),
        use_trees_(use_trees) {}

  // Once per step, with active joints. `contacts`: there are some.
  void prepare(const SolverInput& in, StepContext& c, bool contacts);
  // Each substep: rows at the poses now, effective masses, warm start, and the biased pass; then the other one.
  void solve(const SolverInput& in, StepContext& c);
  void relax(const SolverInput& in, StepContext& c);
  // Between the two: joints hold again after an impact.
  void project(const SolverInput& in, StepContext& c);
  void finish(const SolverInput& in, StepContext& c) { wide_.store(in, c); }  // once per step: impulses stored
  bool is_clear() const { return key_count_ == 0 && blocks_.empty(); }
  void clear();

  std::span<const std::uint32_t> bodies() const { return {bodies_.data(), bodies_.size()}; }  // on joints, ascending

  // Of the inverse inertias, that joints use; by solver index.
  std::span<const Real> shares() const { return {share_.data(), share_.size()}; }

  // Pseudo-velocities, by solver index; empty where there are none.
  std::span<const BodySlide> slides() const { return {slides_.data(), slides_.size()}; }
  // All joints are solved by trees_: none needs a biased impulse.
  bool all_direct() const { return all_direct_; }

 private:
  // A row prepared for the iteration.
  struct ReadyRow {
    Vec3 linear, angular_a, angular_b;
    Vec3 push_a, push_b;      // inverse inertia x angular part
    Real bias, relaxed_bias;  // m/s
    Real mass_scale, impulse_scale;
    Real relaxed_mass_scale, relaxed_impulse_scale;
    Real lower, upper;  // of the accumulated impulse, N s
  };
  // Lower triangle of L and the inverse pivots.
  struct ReadyBlock {
    Real factor[15];
    Real inv_pivot[6];
  };
  bool is_direct(std::size_t block) const;
  void add_strain(const SolverInput& in, std::uint32_t index, const Vec3& arm, Real pull);
  void stabilize(const SolverInput& in, Real h);
  void update_inertias(const SolverInput& in, StepContext& c);
  bool update_inertia(const SolverInput& in, std::uint32_t i);
  void find_in_contact(const SolverInput& in);
  void load_motions(const SolverInput& in, Real h);
  // Returns the bias speed of an equality, m/s or rad/s.
  Real prepare_row(const Row& row, Real h, ReadyRow& out) const;
  void bound_bias(const RowBlock& block, Real* impulse);
  void measure_compliance(const RowBlock& block, const SolverInput& in);
  void start_direct(const RowBlock& block, const SolverInput& in) const;
  void respond(const RowBlock& block, const SolverInput& in);
  void prepare_block(const RowBlock& block, const SolverMass& a, const SolverMass& b, ReadyBlock& out) const;
  void apply(const RowBlock& block, const Real* impulse, const SolverInput& in) const;
  void apply_uneven(const RowBlock& block, const Real* impulse, const SolverInput& in) const;
  void push(const RowBlock& block, const Real* impulse, const SolverInput& in) const {
    uneven_ ? apply_uneven(block, impulse, in) : apply(block, impulse, in);
  }
  SequenceHash hash_of(const SolverInput& in, std::span<const std::uint32_t> list) const;
  unsigned sides_of(const SolverInput& in, const SolverJoint& joint) const;
  bool structure_changed(const SolverInput& in, StepContext& c);
  void find_structure(const SolverInput& in, StepContext& c);
  void list_bodies(const SolverInput& in);
  void choose_wide(const SolverInput& in, StepContext& c);
  void start(const SolverInput& in, StepContext& c);
  JointPass pass(const SolverInput& in, const StepContext& c);
  void note_loads(const SolverInput& in, Real h) const;
  void fill_rows(const SolverInput& in, Real h);
  void prepare_rows(const RowBlock& block, Real h);
  void slide_trees(const SolverInput& in, Real h);
  void bound_slides(Real h);
  void solve_trees(const SolverInput& in, bool biased);
  void list_bounded();
  bool solve_bounded(const SolverInput& in, bool biased);
  bool solve_active(std::span<const std::uint32_t> active, const SolverInput& in, bool biased);
  Real velocity_error(const RowBlock& block, const SolverInput& in, bool biased) const;
  void solve_rows(const SolverInput& in, Real h, bool biased);
  void solve_block(std::size_t index, const SolverInput& in, bool biased);

  Arena& arena_;
  // Of what the order of a solve depends on, by block of joints: that is found anew when one changes, and by nothing
  // else.
  Array<SequenceHash> keys_{&arena_};
  std::size_t key_count_ = 0;                 // joints
  Array<std::uint32_t> bodies_{&arena_};      // solver indices on joints, ascending
  Array<std::uint32_t> narrow_{&arena_};      // joints solved by rows, ascending
  Array<std::uint32_t> candidates_{&arena_};  // joints for wide_
  Array<std::uint8_t> marks_{&arena_};        // by solver index or block
  WideJoints wide_;
  Array<Row> rows_{&arena_};
  Array<RowBlock> blocks_{&arena_};
  Slack rows_slack_, blocks_slack_;
  Array<ReadyRow> ready_{&arena_};
  Array<ReadyBlock> prepared_{&arena_};
  JointTrees trees_{arena_};
  Array<std::uint32_t> bounded_{&arena_};                            // blocks solved with their tree, tree by tree
  Array<std::uint8_t> with_tree_{&arena_};                           // by block: is in bounded_
  Array<Real> bias_{&arena_}, step_{&arena_}, compliance_{&arena_};  // by row, for the trees
  Array<Real> strain_{&arena_};                                      // by solver index: h sum |impulse| |arm|, kg m^2
  Array<Real> norm_{&arena_};                // by solver index: of the inverse inertia, 1/(kg m^2)
  Array<Real> share_{&arena_};               // by solver index: of the inverse inertia that joints use
  Array<Real> smooth_{&arena_};              // by solver index: of the bend of its anchors that rows expect
  Array<Vec3d> strain_axes_{&arena_};        // the same by principal axis, of uneven bodies
  Array<BodyMotion> motions_{&arena_};       // by solver index
  UnionFind groups_{arena_};                 // of solver bodies that joints connect
  Array<std::uint8_t> in_contact_{&arena_};  // by solver index: joints connect it to a body in contact
  Array<std::uint32_t> torn_{&arena_};       // blocks with a bias above push_speed
  Array<BodySlide> slides_{&arena_};         // by solver index
  Array<Real> fastest_{&arena_};             // by root of a tree: rad/s
  Array<Mat3> inv_inertia_{&arena_};         // by solver index, world, for the joints of this substep
  Real hertz_, damping_ratio_, push_speed_;
  bool use_trees_;
  bool contacts_ = false;  // there are contacts
  bool drifted_ = false;   // bodies have moved since the rows were filled
  bool all_direct_ = false;
  bool strained_ = false;         // some share_ is below 1
  bool inertia_changed_ = false;  // since the substep before
  bool uneven_ = false;           // there are jointed bodies with uneven moments
  SoftFactors stiff_factors_{};
};

}  // namespace feder
