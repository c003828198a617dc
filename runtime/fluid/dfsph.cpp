// Divergence-free SPH, in the spirit of Bender & Koschier ("Divergence-Free SPH for Incompressible and Viscous Fluids",
// TVCG 2017), to the tolerance of the fluid. Differences:
//  - velocities are kept from making the fluid denser than at rest: the one solve that pressure comes from. Its
//    multipliers go on from those of the last substep (new particles begin at 0). What a substep adds to the density in
//    second order, the next one takes back: positions then keep to rest density as those of a constrained mechanical
//    system do (SHAKE: Ryckaert, Ciccotti & Berendsen 1977), and waves keep their energy. A second solve, of positions
//    alone, in each substep costs waves more: it lifts what the first lets sink, and that falls as noise;
//  - only what is too dense by more than 1 % (new particles, blows) is taken out by displacements, which no velocity
//    feels, nor any body;
//  - at the free surface, particles lack neighbours and would sink together until they are as dense as the rest; the
//    share of the kernel that lies in the air follows from the gradient of the density (BoundaryTable::air) and is
//    counted as fluid;
//  - boundaries are images of the fluid (images.h), with their exact gradients;
//  - pressure compresses it, by half its tolerance at the bottom of a column;
//  - what a solve may leave grows with the typical speed of the fluid: less than that makes noise, of which calm water
//    must have none (the error of the density, which the next substep takes back, stays below the tolerance);
//  - the shortest waves of the velocities are damped under gravity: noise, which pressure would keep;
//  - conjugate gradients with bounds (pressure_system.h) in place of Jacobi steps.
// Bodies are part of the system: their masses are in it, and they move with every iteration.
// Kept between calls: the multipliers, in FluidPool::lambda, kg m^2/s, over h V the pressure; FluidPool::excess. Weak
// spots: a lattice that a flow stirs loses energy as it breaks up, and in more substeps than it needs, in which it is
// stiffer (kStiffness), a flow loses more (scenes/study/taylor_green.lua); slow flow over many spacings, for which what
// a solve leaves is much, swings about its course (scenes/study/poiseuille.lua: by 1 to 8 % of its speed, of the other
// solvers 1 to 2 %); the kernel "cubic" shortens the period of waves; pressure pulls only where
// negative_pressure says so, and water that it pulls on goes on moving a little.
#include <algorithm>
#include <cmath>
#include <string>

#include "base/cast.h"
#include "fluid/components.h"
#include "fluid/pressure_system.h"
#include "fluid/solver.h"

namespace feder {
namespace {

// Spacings that particles or bodies move in a solver substep: half as far where the fluid is twice as dense as its
// tolerance allows, as steps are then too long for its eddies.
constexpr Real kCflTravel = Real(0.8), kMostRefined = 2;
constexpr int kMostIterations = 100;  // of a solve
// Growth of the density that a solve may leave in a substep: what is left of it is noise, which calm water shows and a
// splash does not. A share of the tolerance at least, and of the way of a typical particle in spacings, up to the
// tolerance and kMostGrowth.
constexpr double kLeastGrowth = 0.05, kGrowthByTravel = 0.012, kMostGrowth = 0.001;
constexpr Real kLivelyTravel = Real(0.04);  // in a substep, in spacings, of a typical particle that hears no noise
constexpr Real kCapillary = Real(0.25);     // of the time of the shortest ripple (Morris 2000)
constexpr Real kCarriedLoad = 1;  // g h^2 H / d^2: how far, in spacings, the pressure of a column moves a particle
constexpr Real kMostRebound = Real(0.01);  // of the density ratio, that velocities take back in a substep
constexpr Real kLoosest = Real(0.01);      // of the tolerances that are used: with looser ones water boils
constexpr Real kStiffness = 20;            // least (c h / d)^2, c the speed of sound
constexpr Real kAtmosphere = 101325;       // Pa
constexpr Real kOpen = Real(0.15);         // share of the kernel in the air, from which on there is no suction
constexpr Real kRepulsion = Real(0.3);     // of the suction, between particles a spacing apart
// Of the pressure, with the tension of the colour field, in the plane and in space. Four times that in the plane, 2.5
// times in space tears drops apart.
constexpr Real kSkinRepulsion[2] = {Real(0.5), Real(0.2)};
constexpr Real kSpread = Real(0.06);          // of the gradient of the density ratio times the squared support
constexpr Real kMostSpread = Real(0.1);       // spacings
constexpr Real kMaxShift = Real(0.5);         // spacings, of a displacement
constexpr double kMissed = 10;                // times the tolerance: errors that are worth a warning
constexpr Real kBudgetPatience = Real(0.25);  // s, for which a solve fails before a warning: splashes pass

class Dfsph final : public FluidSolver {
 public:
  explicit Dfsph(Arena& arena) : system_(arena) {}
  void keep(FluidPool& p) const override { p.keep_solved(); }
  void add_passes(StepPlan& plan) override {
    plan.add<&Dfsph::choose_steps>(Rank::fluid_choose, "dfsph substeps", Fluid::kName, this);
    plan.add<&Dfsph::sort>(Rank::fluid_predict, "dfsph sort", Fluid::kName, this);
    plan.add<&Dfsph::search>(Rank::fluid_neighbors, "dfsph neighbors", Fluid::kName, this);
    plan.add<&Dfsph::boundary_contacts>(Rank::fluid_boundary, "dfsph boundary contacts", Fluid::kName, this);
    plan.add<&Dfsph::correct_density>(Rank::fluid_pressure, "dfsph density", Fluid::kName, this);
    plan.add<&Dfsph::correct_velocities>(Rank::fluid_friction, "dfsph divergence", Fluid::kName, this);
    plan.add<&Dfsph::move>(Rank::fluid_move, "dfsph move", Fluid::kName, this);
    plan.add<&Dfsph::project>(Rank::fluid_project, "dfsph non-penetration", Fluid::kName, this);
    plan.add<&Dfsph::check_budget>(Rank::fluid_check, "dfsph budget", Fluid::kName, this);
  }
  Real pressure(const FluidPool& p, std::uint32_t i) const override {
    FEDER_ASSERT(i < p.count);
    if (!(p.last_h > 0)) return 0;
    return p.ratio[i] * p.ratio[i] * p.lambda[i] / (p.last_h * p.volume) - p.inward;
  }
  bool iterates() const override { return true; }
  bool bears_suction() const override { return true; }
  bool bears_color_field() const override { return true; }

 private:
  void choose_steps(StepContext& c);
  void sort(StepContext& c);
  void search(StepContext& c);
  void boundary_contacts(StepContext& c);
  void correct_density(StepContext& c);
  void correct_velocities(StepContext& c);
  void move(StepContext& c);
  void project(StepContext& c) { project_within(h_, c); }
  void check_budget(StepContext& c);
  Real wanted_steps(FluidPool& p, const StepContext& c) const;
  void find_compliance(FluidPool& p) const;
  void find_suction(FluidPool& p, std::uint32_t i) const;
  void keep_apart(FluidPool& p, Real share, Real most, StepContext& c) const;
  void spread(FluidPool& p, StepContext& c) const;
  static Real tolerance(const FluidPool& p) { return std::min(p.desc.tolerance / 100, kLoosest); }
  // Of a typical particle in a substep, in spacings.
  Real travel(const FluidPool& p) const { return h_ * p.pace / p.desc.spacing; }
  double velocity_tolerance(const FluidPool& p) const;
  double list_pools(StepContext& c);
  PressureSystem system_;
  Real h_ = 0;  // s, of a solver substep
};

// Solver substeps that nothing passes through anything in, and that a column does not boil in.
Real Dfsph::wanted_steps(FluidPool& p, const StepContext& c) const {
  const Real d = p.desc.spacing;
  const ColumnScales column = column_scales(p, c);
  const Real travel = kCflTravel * d / std::clamp(p.excess / tolerance(p), Real(1), kMostRefined);
  const Real speed = speed_near(p, column, *boundary, travel, c);
  p.pace = column.pace;
  p.head = column.head;
  const Real load = p.head * c.h * c.h / (d * d);
  const Real ripple = kCapillary * capillary_time(p, d);
  return std::ceil(std::max({c.h * speed / travel, std::sqrt(load / kCarriedLoad), c.h / ripple, Real(1)}));
}

void Dfsph::choose_steps(StepContext& c) {
  for (FluidPool* pool : pools) {
    FluidPool& p = *pool;
    if (!p.active()) continue;
    const Real wanted = wanted_steps(p, c), most = static_cast<Real>(p.desc.max_substeps);
    if (wanted > most && !p.warned_budget) {
      p.warned_budget = true;
      c.events->warn("fluid_budget",
                     "dfsph needs " + std::to_string(whole_count(wanted)) +
                         " steps of its own in a substep, for the speed of its particles or the weight of its column; "
                         "max_substeps allows " +
                         std::to_string(p.desc.max_substeps) +
                         ": it may be compressed; take a larger max_substeps, more substeps or a larger spacing",
                     p.object);
    }
    want_steps(p, static_cast<int>(std::min(wanted, most)), c);
  }
}

void Dfsph::sort(StepContext& c) {
  h_ = c.h / static_cast<Real>(c.inner.count);
  FEDER_ASSERT(h_ > 0 && h_ <= c.h);
  if (c.inner.index == 0) {
    boundary->move_to(0);
    for (BoundaryBody& b : boundary->bodies) b.contact_weight = 0;  // set by the group before
  }
  each(c, [&](FluidPool& p) { p.sort_by_cell(*c.jobs); });
}

void Dfsph::search(StepContext& c) {
  each(c, [&](FluidPool& p) { p.find_neighbors(*c.jobs, 0); });
}

void Dfsph::boundary_contacts(StepContext& c) {
  each(c, [&](FluidPool& p) {
    std::copy(p.x.begin(), p.x.begin() + p.count, p.start.begin());
    p.find_contacts(*c.jobs, *boundary, h_, c.gravity, true);
    p.share_bodies(*boundary);
  });
}

// The fluid is given a bulk modulus, so that pressure stays finite where it has no room, in full vessels and under
// pistons: at the bottom of a column at rest it is denser by half the tolerance. Implicit, so it needs no small steps.
void Dfsph::find_compliance(FluidPool& p) const {
  const Real d = p.desc.spacing, strain = tolerance(p) / 2;
  const Real sound2 = std::max(p.head / strain, kStiffness * d * d / (h_ * h_));
  p.compliance = 1 / (h_ * h_ * p.mass * sound2);
}

// Within the fluid, not at its surface, pressure may pull, and then densities are kept from falling as well.
void Dfsph::find_suction(FluidPool& p, std::uint32_t i) const {
  const Real inside = clamp(1 - p.air[i] / kOpen, 0, 1);
  p.least[i] = -inside * p.fluid_of(i).desc.negative_pressure * kAtmosphere * h_ * p.fluid_of(i).volume;
  p.lambda[i] = std::max(p.lambda[i], p.least[i]);
  if (inside > 0) p.allowed[i] = clamp(1 - p.ratio[i], -kMostRebound, kMostRebound) / h_;
}

// Of the growth of the density in a substep. Where there is no room, noise would feed on what is left.
double Dfsph::velocity_tolerance(const FluidPool& p) const {
  const double whole = static_cast<double>(tolerance(p)), least = kLeastGrowth * whole;
  if (p.too_dense > 0) return least;
  return std::clamp(kGrowthByTravel * static_cast<double>(travel(p)), least,
                    std::max(least, std::min(whole, kMostGrowth)));
}

// Lists the pools of the group in the system; the tolerance of the strictest.
double Dfsph::list_pools(StepContext& c) {
  double least = 1;
  system_.begin(boundary);
  each(c, [&](FluidPool& p) {
    system_.add(p);
    least = std::min(least, static_cast<double>(tolerance(p)));
  });
  return least;
}

// Densities and, where they are far too high, displacements that no velocity feels.
void Dfsph::correct_density(StepContext& c) {
  const double wanted = list_pools(c);
  if (system_.empty()) return;
  system_.prepare(*c.jobs);
  bool far = false;
  each(c, [&](FluidPool& p) {
    const PressureSystem::Excess e = system_.excess(p, kMostRebound, *c.jobs);
    p.excess = static_cast<Real>(e.mean);
    p.too_dense = e.mean > kMissed * wanted ? p.too_dense + h_ : Real(0);
    far = far || e.beyond;
  });
  if (!far) return;
  each(c, [&](FluidPool& p) {
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i)
        p.allowed[i] = p.ratio[i] > 1 ? std::min(1 + kMostRebound - p.ratio[i], Real(0)) : 1 - p.ratio[i];
    });
  });
  const int iterations = system_.solve_displacements(wanted, kMostIterations, *c.jobs).iterations;
  if (iterations == 0) return;
  each(c, [&](FluidPool& p) {
    p.iterations += static_cast<std::uint64_t>(iterations);
    const Real longest = kMaxShift * p.desc.spacing;
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3 by = p.extra[i].vec();
        const Real far_by = length(by);
        p.x[i].set(p.x[i].vec() + (far_by > longest ? Vec3(longest / far_by * by) : by));
      }
    });
  });
  system_.prepare(*c.jobs);
}

void Dfsph::correct_velocities(StepContext& c) {
  list_pools(c);
  if (system_.empty()) return;
  double wanted = 1e300;
  each(c, [&](FluidPool& p) { wanted = std::min(wanted, velocity_tolerance(p) / static_cast<double>(h_)); });
  each(c, [&](FluidPool& p) {
    const Real scale = p.last_h > 0 ? h_ / p.last_h : Real(0);
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        const Real room =
            p.ratio[i] > 1 ? std::max(1 - p.ratio[i], -kMostRebound) : std::max(Real(0), 1 - p.air[i] - p.ratio[i]);
        p.allowed[i] = room / h_;
        p.lambda[i] *= scale;
        if (!p.least.empty()) find_suction(p, i);
        p.v[i].set(p.v[i].vec() + h_ * p.fluid_of(i).desc.gravity_scale * c.gravity);
      }
    });
    find_compliance(p);
    if (travel(p) <= kLivelyTravel) damp_still_noise(p, h_, c);
    if (p.desc.viscosity > 0 && !needs_implicit_viscosity(p, h_)) add_viscosity(p, *boundary, h_, c);
    if (has_tension(p)) add_tension(p, *boundary, h_, c);
    if (p.desc.vorticity > 0) confine_vorticity(p, h_, c);
    if (!p.least.empty()) keep_apart(p, kRepulsion, 0, c);
    if (tension_by_color(p)) keep_apart(p, kSkinRepulsion[p.dimension - 2], p.color_energy * h_ * p.volume, c);
    p.last_h = h_;
    ++p.steps;
  });
  system_.start_velocities(*c.jobs);
  // with the pressure of the last substep in the velocities, or friction at the walls would carry what it should; thin
  // fluids before, as the noise of that pressure would cost a flow its energy (Taylor-Green with 4 substeps: 20 %)
  each(c, [&](FluidPool& p) {
    if (p.desc.viscosity > 0 && needs_implicit_viscosity(p, h_)) add_viscosity(p, *boundary, h_, c);
  });
  const PressureSystem::Result r = system_.solve_velocities(wanted, kMostIterations, *c.jobs);
  each(c, [&](FluidPool& p) {
    p.iterations += static_cast<std::uint64_t>(r.iterations);
    p.unsolved = r.error > kMissed * wanted ? p.unsolved + h_ : Real(0);
    if (boundary->weighed) p.weigh_fixed(*boundary, c);
  });
}

// Under suction particles cluster and leave holes (Swegle, Hicks & Attaway 1995). Two things together prevent that,
// each alone loses a siphon within a second: close pairs repel each other by a share of it (Monaghan 2000) ...
// Under the tension of the colour field they gather to strings along the surface, more and more of them, and a drop
// loses its tension (a tenth is left after six swings), unless close pairs repel each other by a share of the pressure,
// `most` at most, as a multiplier.
void Dfsph::keep_apart(FluidPool& p, Real share, Real most, StepContext& c) const {
  SweepInput in = p.sweep_input();
  const double at_rest = p.kernel->density.value(p.dimension, static_cast<double>(p.finest / p.support));
  in.near = static_cast<Real>(p.kernel->norm_density[p.dimension - 2] / at_rest);
  p.weigh(*c.jobs, [&](std::uint32_t i) { return share * std::max(-p.lambda[i], std::min(p.lambda[i], most)); });
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->push_near(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i)
      p.v[i].set(p.v[i].vec() - p.slope_factor / p.mass_of(i) * p.move[i].vec());
  });
  p.clear_weights(*c.jobs);
}

// ... and particles are shifted to where there are fewer (Lind, Xu, Stansby & Rogers 2012).
void Dfsph::spread(FluidPool& p, StepContext& c) const {
  const SweepInput in = p.sweep_input();
  const Real by = kSpread * p.support * p.support, most = kMostSpread * p.desc.spacing;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data());
    p.even_slopes(first, last);
    for (std::uint32_t i = first; i < last; ++i) {
      const Vec3 denser = by * (p.slope_factor * p.move[i].vec() + p.images->gradient(i));
      const Real far = length(denser);
      p.move[i].set(p.least[i] < 0 ? Vec3((far > most ? most / far : Real(1)) * denser) : Vec3(Vec3::Zero()));
    }
  });
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) p.x[i].set(p.x[i].vec() - p.move[i].vec());
  });
}

void Dfsph::move(StepContext& c) {
  each(c, [&](FluidPool& p) {
    if (!p.least.empty()) spread(p, c);
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) p.x[i].set(p.x[i].vec() + h_ * p.v[i].vec());
    });
  });
}

// Once, when the fluid has been too dense, or growing denser, for a while.
void Dfsph::check_budget(StepContext& c) {
  for (FluidPool* p : pools) {
    if (p->count == 0 || p->warned_budget || std::max(p->too_dense, p->unsolved) < kBudgetPatience) continue;
    p->warned_budget = true;
    c.events->warn("fluid_budget",
                   "dfsph is compressed by more than " +
                       std::to_string(static_cast<Real>(kMissed) * p->desc.tolerance) +
                       " %, ten times its tolerance: it has no room, or needs more substeps or a larger spacing",
                   p->object);
  }
}

}  // namespace

Variant<FluidSolver> fluid_dfsph() {
  return {"dfsph", "divergence-free SPH: incompressible to a tolerance",
          [](Arena& arena, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Dfsph>(arena); }};
}

}  // namespace feder
