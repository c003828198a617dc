// Fluid solvers: one file per solver, one feder_variant(fluid <solver>) line. A solver adds its passes for the pools
// that chose it. Contract, checked for every solver by tests/fluid/test_solver_contract.cpp:
//  - a column at rest has the pressure of its weight and keeps its level;
//  - a free blob keeps its momentum; no particle passes a boundary;
//  - same bits for any number of threads.
#pragma once
#include <algorithm>

#include "base/registry.h"
#include "feder/plan.h"
#include "fluid/boundary.h"
#include "fluid/pool.h"

namespace feder {

class FluidSolver {
 public:
  virtual ~FluidSolver() = default;
  // Passes at Rank::fluid_choose, where want_steps() says how many fluid substeps each pool needs, in the loop of fluid
  // substeps, and at Rank::fluid_check. Before them new particles have been added and the boundary is set, after them
  // the velocities of the bodies are read; positions and velocities are those of the end of the substep.
  virtual void add_passes(StepPlan& plan) = 0;
  // Pa, from `ratio` and what the pool keeps; without what balances the cohesion.
  virtual Real pressure(const FluidPool& p, std::uint32_t i) const = 0;
  // True: a substep solves for the pressure in `iterations`, with `stiffness`. Others derive both from `compression`,
  // and take up to `max_substeps` solver substeps.
  virtual bool iterates() const { return false; }

  std::vector<FluidPool*> pools;
  Boundary* boundary = nullptr;

 protected:
  // At Rank::fluid_choose. A pool that asks for none is left out.
  static void want_steps(const FluidPool& p, int count, StepContext& c) {
    int& of_group = c.counts(Loop::fluid).count[p.group];
    of_group = std::max(of_group, count);
  }
  // In the loop: the pools of the running group that are this solver's.
  template <class F>
  void each(const StepContext& c, F&& f) {
    for (FluidPool* p : pools)
      if (p->count > 0 && !p->frozen && p->group == static_cast<std::uint32_t>(c.inner.group)) f(*p);
  }
};

std::span<const Variant<FluidSolver>> fluid_solvers();

// Viscosity between particles and at the boundary, and surface tension, applied to velocities for h seconds; bodies
// take the opposite impulses. Viscosity runs in rounds where stability requires them.
void add_viscosity(FluidPool& p, Boundary& boundary, Real h, StepContext& c);
void add_tension(FluidPool& p, Boundary& boundary, Real h, StepContext& c);

}  // namespace feder
