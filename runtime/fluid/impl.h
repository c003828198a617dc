// The parts of the fluid system that its files share. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "fluid/solver.h"
#include "step/watch.h"

namespace feder {

// Plain data, saved as bytes; nozzle sites follow from the settings.
struct FluidEmitter {
  ObjectId object, fluid;
  Vec3 position = Vec3::Zero(), direction = Vec3::Zero();
  Real speed = 0, radius = 0, rate = 0;  // rate: particles per second, 0 a full jet
  std::uint64_t limit = 0, made = 0;
  double clock = 0;  // s, for which it has been running
  std::uint32_t running = 1, done = 0;
};

struct FluidDrain {
  ObjectId object, fluid;
  std::uint32_t shape = 0;  // in Impl::shapes
  std::uint32_t unused = 0;
  Pose pose;
  std::uint64_t taken = 0;
};

struct Fluid::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  Objects& objects;
  Watch& watched;
  Boundary& boundary;
  int dimension;
  bool* structure_changed;
  std::vector<std::unique_ptr<FluidPool>> pools;      // by object index
  std::vector<std::unique_ptr<FluidSolver>> solvers;  // by row of fluid_solvers(); null while no pool uses it
  std::vector<FluidEmitter> emitters;                 // by object index
  std::vector<FluidDrain> drains;
  std::vector<ShapePtr> shapes;       // of drains, never removed: a snapshot may need them
  Array<std::uint8_t> marked;         // work: particles to remove
  Array<Aabb> swept;                  // work: by pool of a solver
  Array<std::uint32_t> group_number;  // likewise
  std::uint64_t lost = 0;             // particles removed because they went non-finite

  FluidPool& pool(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kFluidKind);
    return *pools[objects.index(id)];
  }
  FluidSolver& solver_of(const FluidPool& p);
  void validate_sources() const;  // validate.cpp
  void group_pools();
  void make_room();  // outside steps: for particles of the emitters
  std::vector<Vec3> sites(const FluidEmitter& e, const FluidPool& p) const;
  double full_rate(const FluidEmitter& e, const FluidPool& p) const;

  // Passes.
  void make_groups(StepContext& c);
  void join_pools(const std::vector<FluidPool*>& members, StepContext& c);
  void emit(StepContext& c);
  void relax(StepContext& c);
  void project(StepContext& c);
  void drain(StepContext& c);
  void check(StepContext& c);
  // watch.cpp
  void watch(FluidPool& p, double square, StepContext& c);  // square: sum of the squared speeds, m^2/s^2
  void suspect(const FluidPool& p);
  void run_emitter(FluidEmitter& e, StepContext& c);

  void refresh(FluidPool& p);  // lists, contacts and density ratios at the present positions, for queries
  std::vector<std::uint32_t> by_id(const FluidPool& p) const;
  JobPool one_thread{1};
};

}  // namespace feder
