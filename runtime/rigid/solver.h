// Rigid solvers: contacts and joint rows in, velocities and displacements of solver bodies out. They know no joint
// kinds, shapes or bodies. One file per solver, one feder_variant(rigid <solver>) line. Contract, checked for every
// variant by tests/rigid/test_solver_contract.cpp: free fall, momentum with contacts and joints, friction, stacking,
// bounce, determinism over threads.
#pragma once
#include <span>

#include "base/registry.h"
#include "constrain/joint.h"
#include "feder/params.h"
#include "feder/plan.h"
#include "rigid/jointed_body.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "state/solver_bodies.h"

namespace feder {

// A joint as the solver sees it; owned by the rigid system.
struct SolverJoint {
  const JointKind* kind = nullptr;
  JointShape shape;
  std::uint32_t slot_a = kNone, slot_b = kNone;  // solver slot; kNone = world
  Real impulse[kMaxJointRows] = {};              // of the last substep, by row; warm start
  std::uint8_t rows = 0;
  std::uint8_t active = 0;     // this step: at least one awake side
  std::uint8_t breakable = 0;  // solvers note its load (joint_load.h)
  Real peak_force = 0;         // in this step: the largest of its substeps, N
};

inline constexpr int kLevels = 6;  // of islands, see SolverInput::levels

struct ContactSpring {
  Real rate = 0;   // angular frequency, with the mass of the lighter body, 1/s; 0: contacts do not give way
  Real crowd = 0;  // softer by so much per contact of a body above one
};

struct SolverInput {
  // Solver index of what owns the collider; 0: the world.
  std::uint32_t solver_index(std::uint32_t collider) const {
    return solver_bodies->at(colliders->solver_slot[collider]);
  }
  // A joint for its kind, at the poses now.
  JointInput joint_input(const SolverJoint& j) const {
    const std::uint32_t a = solver_bodies->at(j.slot_a), b = solver_bodies->at(j.slot_b);
    return {&j.shape, solver_bodies->pose(a), solver_bodies->pose(b), a, b};
  }
  JointedBody* uneven(std::uint32_t index) const { return uneven_of(jointed, index); }

  Contacts* contacts = nullptr;  // active ones are solved; impulses are read and written
  const Colliders* colliders = nullptr;
  SolverBodies* solver_bodies = nullptr;
  std::span<SolverJoint> joints;
  std::span<const std::uint32_t> active_joints;     // indices into joints, ascending
  std::span<const std::uint32_t> breakable_joints;  // those of them whose load is noted
  std::span<JointedBody> jointed;                   // by solver index, of bodies; empty without joints
  // By solver index: the body's contacts want 2^level pieces of a substep, the same for all of an
  // island. Empty: no body does.
  std::span<const std::uint8_t> levels;
};

// Called by the rigid system's passes. Rigid bodies come first; the solver bodies behind them were advanced by their
// owners (net points): their velocity is integrated already, and delta_position is that before this substep.
class RigidSolver {
 public:
  virtual ~RigidSolver() = default;
  virtual void prepare(const SolverInput& in, StepContext& c) = 0;  // once, before the first substep
  // Each substep: velocities in; velocities, displacements and rotations out.
  virtual void solve(const SolverInput& in, StepContext& c) = 0;
  virtual void finish(const SolverInput& in, StepContext& c) = 0;  // once: restitution, impulses stored
  // Contacts as springs, for substeps of h seconds.
  virtual ContactSpring contact_spring(Real /*h*/) const { return {}; }
  // Mass ratio along a tree of joints that one substep holds; 0: no more than along a loop.
  virtual Real tree_ratio() const { return 0; }
  virtual bool wide() const { return true; }          // kernels may take the vector instructions of the processor
  virtual std::uint64_t capped() const { return 0; }  // times an iteration limit was reached in the last step
};

std::span<const Variant<RigidSolver>> rigid_solvers();
// The variant that the options name; soft_step by default, or the first of this build.
const Variant<RigidSolver>& rigid_solver(const Params& options);

}  // namespace feder
