// Fluid solvers: one file per solver, one feder_variant(fluid <solver>) line. A solver adds its rows for the pools that
// chose it. Contract, checked for every row by tests/fluid/test_solver_contract.cpp: a column at rest has the pressure
// of its weight and keeps its level; a free blob keeps its momentum; nothing passes a wall; same bits for any number
// of threads.
#pragma once
#include "base/registry.h"
#include "fluid/pool.h"
#include "step/plan.h"

namespace feder {

class FluidSolver {
 public:
  virtual ~FluidSolver() = default;
  // Rows of the stage `advance` with ranks 24 to 31: before them new particles have come in and the walls are set,
  // after them the velocities of the bodies are read; positions and velocities are those of the end of the substep.
  virtual void add_rows(StepPlan& plan) = 0;
  // Pa, from `ratio` and what the pool keeps; without what balances the cohesion.
  virtual Real pressure(const FluidPool& p, std::uint32_t i) const = 0;
  // Does a substep solve for the pressure in `iterations`, with `stiffness`? Others derive both from `compression`, and
  // take up to `max_substeps` steps of their own.
  virtual bool iterates() const { return false; }

  std::vector<FluidPool*> pools;
  Walls* walls = nullptr;
};

std::span<const Variant<FluidSolver>> fluid_solvers();

// Friction between particles and at walls, and surface tension, applied to velocities for h seconds; bodies get what
// the fluid loses. In substeps of their own where stability asks for them.
void add_viscosity(FluidPool& p, Walls& walls, Real h, StepContext& c);
void add_tension(FluidPool& p, Walls& walls, Real h, StepContext& c);

}  // namespace feder
