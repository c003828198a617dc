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
  // Makes a new pool keep what the solver needs of it, outside steps.
  virtual void keep(FluidPool&) const {}
  // Passes at Rank::fluid_choose, where want_steps() says how many fluid substeps each pool needs, in the loop of fluid
  // substeps, and at Rank::fluid_check. Before them new particles have been added and the boundary is set, after them
  // the velocities of the bodies are read; positions and velocities are those of the end of the substep.
  virtual void add_passes(StepPlan& plan) = 0;
  // Pa, from `ratio` and what the pool keeps; without what balances the cohesion.
  virtual Real pressure(const FluidPool& p, std::uint32_t i) const = 0;
  // True: a substep solves for the pressure, and bodies move with it; pools that press on one body form a group.
  virtual bool iterates() const { return false; }
  // Of the densities of fluids that touch.
  virtual Real most_density_ratio() const { return 1000; }
  // True: negative_pressure counts.
  virtual bool bears_suction() const { return false; }
  virtual bool bears_color_field() const { return false; }
  // True: as stiff as `stiffness` says. Others are as stiff as `compression` or `tolerance` asks for.
  virtual bool takes_stiffness() const { return false; }

  std::vector<FluidPool*> pools;
  Boundary* boundary = nullptr;

 protected:
  // At Rank::fluid_choose. A pool that asks for none is left out.
  static void want_steps(const FluidPool& p, int count, StepContext& c) {
    int& of_group = c.counts(Loop::fluid).count[p.group];
    of_group = std::max(of_group, count);
  }
  // Non-penetration projection between the solver substeps, h seconds each; after the last one Fluid does it at the
  // bodies' new poses.
  void project_within(Real h, StepContext& c) {
    if (c.inner.last()) return;
    boundary->move_to(h * static_cast<Real>(c.inner.index + 1));
    each(c, [&](FluidPool& p) { p.project_out(*boundary, *c.jobs); });
    for (BoundaryBody& b : boundary->bodies) b.contact_weight = 0;
  }
  // In the loop: the pools of the running group that are this solver's.
  template <class F>
  void each(const StepContext& c, F&& f) {
    for (FluidPool* p : pools)
      if (p->active() && p->group == static_cast<std::uint32_t>(c.inner.group)) f(*p);
  }
};

std::span<const Variant<FluidSolver>> fluid_solvers();

// Bounds of the particles of a pool and of their supports in the coming substep. groups.cpp
Aabb swept_bounds(const FluidPool& p, const StepContext& c);

// Viscosity between particles and at the boundary, and surface tension, applied to velocities for h seconds; bodies
// take the opposite impulses. Viscosity is implicit where it has to be (viscosity.cpp).
bool needs_implicit_viscosity(const FluidPool& p, Real h);
void add_viscosity(FluidPool& p, Boundary& boundary, Real h, StepContext& c);
// What makes the sum of Sweeps::viscous a Laplacian, times `by`.
Real laplacian_factor(const FluidPool& p, Real by);
// In which a ripple of that wave length swings, over 2 pi, s (Brackbill, Kothe & Zemach 1992), by tension or adhesion,
// whichever is more; infinite without.
Real capillary_time(const FluidPool& p, Real length);
inline bool has_tension(const FluidPool& p) { return p.desc.surface_tension > 0 || p.desc.adhesion > 0; }
inline bool tension_by_color(const FluidPool& p) { return p.colored && p.desc.surface_tension > 0; }
void add_tension(FluidPool& p, Boundary& boundary, Real h, StepContext& c);
// For h seconds, where desc.vorticity is above 0.
void confine_vorticity(FluidPool& p, Real h, StepContext& c);
// Takes noise out of what weighs, for h seconds. Without, still water goes on moving with the energy of its settling,
// as a thermal bath: pressure takes none.
void damp_still_noise(FluidPool& p, Real h, StepContext& c);
// Takes `share` of the shortest waves of the velocities out, less of longer ones by the fourth power of their number:
// noise, not flow; density ratios must be fresh. Momentum stays, with kernels of radial viscosity angular momentum as
// well.
void damp_noise(FluidPool& p, Real share, StepContext& c);

}  // namespace feder
