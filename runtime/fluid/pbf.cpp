// Position based fluid: every particle has the constraint C = density / rest density - 1 <= 0, and a substep moves
// predicted positions until the constraints hold. Macklin & Mueller, "Position Based Fluids", TOG 2013, with the
// compliance of XPBD (Macklin, Mueller & Chentanez 2016): lambda has the unit kg m^2, and -lambda/(h^2 V) is the
// pressure. What differs:
//  - the iterations of a substep are Jacobi steps of unequal length, the roots of a Chebyshev polynomial (Richardson's
//    method): n of them hold a deep column about as well as n^2 equal ones;
//  - lambda is clamped to pressure (p >= 0): the fluid does not pull, so it neither hangs on walls nor holds suction;
//  - walls enter by a function of the distance (sph/wall_table.h), and bodies move with the iterations.
// All particles move at once from the same positions, so order and threads do not matter. A body that is shared by
// many particles is given to each of them in part (Tonge, Benevolenski & Voroshilov, "Mass Splitting", TOG 2012).
// A substep of the world is taken in several own steps where particles would pass each other or a column would be
// crushed, which no number of iterations stands: by how far the fluid and the walls near it move, and by the
// compression that few iterations leave, about g h^2 N^2 / (2 n^2 d) for N layers and n iterations. A warning says when
// the fluid is denser than wanted all the same.
// Kept between calls: nothing; lambda stays for questions. (Keeping it as a warm start makes it the integral of the
// error in density, which swings for seconds.) Weak spot: pressure waves are damped.
#include <algorithm>
#include <cmath>

#include "fluid/solver.h"

namespace feder {
namespace {

constexpr double kSpectrum = 4;          // no eigenvalue of the scaled system is larger: 2.8 to 3.5 on lattices
constexpr double kDamping = 0.1;         // how far the largest eigenvalues are damped beyond holding them
constexpr Real kMostExcess = Real(0.5);  // of particles over each other that one iteration answers to: bounds their way
constexpr Real kMostWall = 1;            // of walls; likewise
constexpr Real kMostWay = 1;             // spacings that particles or walls move in an own step
constexpr Real kMostCrush = 1;           // of the compression that is expected of an own step
constexpr Real kCompany = Real(0.2);     // that neighbours add to density over density at rest of who is not alone
constexpr Real kPatience = Real(0.25);   // s for which the fluid is too dense before a warning: splashes pass

// Of iteration k of n: long and short ones in turn, so that what a long one throws up a short one takes back.
Real step_length(int k, int n) {
  const int root = k % 2 == 0 ? n / 2 + k / 2 : k / 2;
  const double angle = 3.14159265358979323846 * (2 * root + 1) / (2 * n);
  return static_cast<Real>(2 / (kSpectrum * (1 + kDamping - (1 - kDamping) * sin_cos_cos(angle))));
}

class Pbf final : public FluidSolver {
 public:
  void add_rows(StepPlan& plan) override {
    plan.add<&Pbf::own_steps>(Stage::advance, When::each_substep, 25, "own steps but the last", Fluid::kName, this);
    plan.add<&Pbf::predict>(Stage::advance, When::each_substep, 26, "predict and sort", Fluid::kName, this);
    plan.add<&Pbf::search>(Stage::advance, When::each_substep, 27, "neighbors", Fluid::kName, this);
    plan.add<&Pbf::meet_walls>(Stage::advance, When::each_substep, 28, "wall contacts", Fluid::kName, this);
    plan.add<&Pbf::solve>(Stage::advance, When::each_substep, 29, "density", Fluid::kName, this);
    plan.add<&Pbf::rub>(Stage::advance, When::each_substep, 30, "friction and tension", Fluid::kName, this);
    plan.add<&Pbf::judge>(Stage::advance, When::each_substep, 31, "compression", Fluid::kName, this);
  }
  Real pressure(const FluidPool& p, std::uint32_t i) const override {
    if (!(p.last_h > 0)) return 0;
    const Real r2 = p.ratio[i] * p.ratio[i];
    return -r2 * p.lambda[i] / (p.last_h * p.last_h * p.volume) - p.inward;
  }
  bool iterates() const override { return true; }

 private:
  void own_steps(StepContext& c);
  Real wanted_steps(const FluidPool& p, const StepContext& c) const;
  void predict(StepContext& c);
  void search(StepContext& c);
  void meet_walls(StepContext& c);
  void solve(StepContext& c);
  void rub(StepContext& c);
  void judge(StepContext& c);
  void correct(FluidPool& p, bool first_round, Real relax, StepContext& c);
  void displace(FluidPool& p, StepContext& c);
  Real distance(const FluidPool& p, const WallContact& k) const;
  template <class F>
  void each(F&& f) {
    for (FluidPool* p : pools)
      if (p->count > 0 && !p->frozen) f(*p);
  }
  Real h_ = 0;  // s, of an own step
};

// For particles in company: what flies alone meets nobody on its way but walls, and is guarded from these.
Real Pbf::wanted_steps(const FluidPool& p, const StepContext& c) const {
  const Vec3 gravity = p.desc.gravity_scale * c.gravity;
  const Real g = length(gravity), d = p.desc.spacing;
  Real speed2 = 0, low = kInfinity;
  double sum = 0;
  std::uint32_t n = 0;
  Aabb box;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    if (p.ratio[i] < p.own_value + kCompany) continue;
    const Vec3 v = p.v[i].vec();
    speed2 = std::max(speed2, dot(v, v));
    const Real s = -dot(gravity, p.x[i].vec());
    low = std::min(low, s), sum += static_cast<double>(s), ++n;
    box.include(p.x[i].vec());
  }
  if (n == 0) return 1;
  Real speed = std::sqrt(speed2);
  box.grow(p.support);
  for (const Wall& w : walls->list) {
    const WallBody& b = walls->bodies[w.body];
    Aabb reach = w.box;
    reach.grow(c.h * length(b.velocity));
    if (overlaps(reach, box)) speed = std::max(speed, length(b.velocity));
  }
  const Real way = c.h * speed / (kMostWay * d);
  if (!(g > 0)) return way;
  // a column twice as high as the mean lies above the lowest
  const Real height = 2 * (static_cast<Real>(sum / n) - low) / g;
  const Real layers = height / d, iterations = static_cast<Real>(p.desc.iterations);
  const Real crush = g * c.h * c.h * layers * layers / (2 * iterations * iterations * d);
  return std::max(way, std::sqrt(crush / kMostCrush));
}

// All of the substep but its last own step, which is what the rows that follow do. All fluids of this solver take the
// same.
void Pbf::own_steps(StepContext& c) {
  Real wanted = 1;
  each([&](FluidPool& p) {
    wanted = std::max(wanted, std::min(wanted_steps(p, c), static_cast<Real>(p.desc.max_substeps)));
  });
  const int steps = static_cast<int>(std::ceil(wanted));
  h_ = c.h / static_cast<Real>(steps);
  for (int k = 1; k < steps; ++k) {
    predict(c), search(c), meet_walls(c), solve(c), rub(c);
    walls->drift(h_);
    each([&](FluidPool& p) { p.guard_walls(*walls); });
    for (WallBody& b : walls->bodies) b.touching = 0;
  }
  walls->drifted = false;  // the last step goes on from here; then bodies are placed anew
}

// After the last iteration: says once when the fluid stays denser than wanted.
void Pbf::judge(StepContext& c) {
  each([&](FluidPool& p) {
    double sum = 0;
    for (std::uint32_t i = 0; i < p.count; ++i) sum += std::max(0.0, static_cast<double>(p.ratio[i]) - 1);
    const Real mean = static_cast<Real>(sum / p.count);
    const Real wanted = p.desc.compression > 0 ? p.desc.compression : Real(0.05);
    p.too_dense = mean > wanted ? p.too_dense + c.h : Real(0);
    if (p.too_dense < kPatience || p.warned_budget) return;
    p.warned_budget = true;
    c.events->warn("fluid_budget",
                   "pbf is compressed by " + std::to_string(mean) + " on average, wanted " + std::to_string(wanted) +
                       ": " + std::to_string(p.desc.iterations) +
                       " iterations do not hold it; take more of them, more substeps or a larger spacing",
                   p.object);
  });
}

void Pbf::predict(StepContext& c) {
  each([&](FluidPool& p) {
    const Vec3 kick = h_ * p.desc.gravity_scale * c.gravity;
    c.jobs->for_blocks(p.count, 4 * kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        p.start[i] = p.x[i];
        const Vec3 v = p.v[i].vec() + kick;
        p.v[i].set(v);
        p.x[i].set(p.x[i].vec() + h_ * v);
      }
    });
    p.sort_by_cell();
  });
}

void Pbf::search(StepContext& c) {
  each([&](FluidPool& p) { p.find_neighbors(*c.jobs, 0); });
}

void Pbf::meet_walls(StepContext& c) {
  each([&](FluidPool& p) {
    p.find_contacts(*c.jobs, *walls, h_, c.gravity, true);
    p.share_bodies(*walls);
  });
}

// From the plane, which has gone with its body since the start of the substep.
Real Pbf::distance(const FluidPool& p, const WallContact& k) const {
  const Vec3 x = p.x[k.particle].vec();
  const Real d = dot(k.normal, x) - k.offset;
  const WallBody& b = walls->bodies[walls->list[k.wall].body];
  return d - h_ * dot(k.normal, b.velocity_at(x));
}

void Pbf::solve(StepContext& c) {
  each([&](FluidPool& p) {
    std::fill(p.lambda.begin(), p.lambda.begin() + p.count, Real(0));
    for (int k = 0; k < p.desc.iterations; ++k) {
      correct(p, k == 0, step_length(k, p.desc.iterations), c);
      displace(p, c);
    }
    p.last_h = h_;
    ++p.steps;
  });
}

// One Jacobi correction of lambda; its change goes into the weight of the particle.
void Pbf::correct(FluidPool& p, bool first_round, Real relax, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real inv_mass = 1 / p.mass, rs = p.support * p.support * p.slope_factor * p.slope_factor;
  const Real compliance = p.desc.stiffness > 0 ? 1 / (p.desc.stiffness * p.volume * h_ * h_) : Real(0);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    if (first_round)
      p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data());
    else
      p.sweeps->values(in, first, last, p.sum.data());
    for (std::uint32_t i = first; i < last; ++i) {
      const Real crowd = p.value_factor * (first_round ? p.move[i].w : p.sum[i]) + p.own_value + p.screen[i];
      Real walled = 0, shared = 0, opposed = 0;
      Vec3 wall = Vec3::Zero();
      for (const WallContact& k : p.contacts_of(i)) {
        const WallSample s = p.table->at(distance(p, k) / p.support);
        walled += s.value;
        if (!first_round) continue;
        const Real slope = s.slope / p.support;
        wall -= slope * k.normal;
        opposed += slope * slope;
        const WallBody& b = walls->bodies[walls->list[k.wall].body];
        if (b.dynamic) shared += slope * std::max(b.touching, slope) * b.response(p.x[i].vec(), k.normal);
      }
      if (first_round) {
        const Vec3 pair = p.slope_factor * p.move[i].vec();
        // between two walls the slopes cancel, but each step changes one against the other: what cancels still counts
        opposed = std::max(Real(0), opposed - wall.squaredNorm());
        p.diagonal[i] =
            inv_mass * std::max(p.least_squares, (pair + wall).squaredNorm() + opposed + rs * p.squares[i]) + shared;
      }
      p.ratio[i] = crowd + walled;
      const Real excess = std::min(crowd - 1, kMostExcess) + std::min(walled, kMostWall), before = p.lambda[i];
      const Real stiff = p.diagonal[i] / relax + compliance;
      const Real after = stiff > 0 ? std::min(Real(0), before - (excess + compliance * before) / stiff) : Real(0);
      p.lambda[i] = after;
      p.sum[i] = after - before;
    }
  });
  for (std::uint32_t i = 0; i < p.count; ++i) p.x[i].w = p.sum[i];
}

// Moves particles by the weights, and bodies against them.
void Pbf::displace(FluidPool& p, StepContext& c) {
  SweepInput in = p.sweep_input();
  const Real inv_mass = 1 / p.mass, rate = 1 / h_;
  // Along the lines of the substep's start, as SHAKE does, angular momentum is kept. Where the particles are predicted,
  // pressure against cohesion turns a drop faster and faster; pressure against gravity turns nothing, and is spared it.
  p.start[p.count] = {};
  in.velocity = &p.start[0].x;
  const auto push = p.desc.surface_tension > 0 ? p.sweeps->push_from : p.sweeps->push;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    push(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      Vec3 move = p.slope_factor * p.move[i].vec();
      for (WallContact& k : p.contacts_of(i)) {
        const Real push = -p.x[i].w * p.table->at(distance(p, k) / p.support).slope / p.support;
        move += push * k.normal;
        k.impulse = push / h_;
      }
      p.move[i].set(inv_mass * move);
    }
  });
  c.jobs->for_blocks(p.count, 4 * kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    // velocities by what the particles were moved, not by where they are: equal and opposite to the last bit nearly,
    // wherever the origin lies
    for (std::uint32_t i = first; i < last; ++i) {
      p.x[i].set(p.x[i].vec() + p.move[i].vec());
      p.v[i].set(p.v[i].vec() + rate * p.move[i].vec());
    }
  });
  for (const std::uint32_t at : p.dynamic_contacts) {
    const WallContact& k = p.contacts[at];
    walls->bodies[walls->list[k.wall].body].push(p.start[k.particle].vec(), -k.impulse * k.normal);
  }
}

void Pbf::rub(StepContext& c) {
  each([&](FluidPool& p) {
    for (std::uint32_t i = 0; i < p.count; ++i) p.x[i].w = 0;
    if (p.desc.viscosity > 0) add_viscosity(p, *walls, h_, c);
    if (p.desc.surface_tension > 0) add_tension(p, *walls, h_, c);
  });
}

}  // namespace

Variant<FluidSolver> fluid_pbf() {
  return {"pbf", "position based, with compliance: large steps, damps",
          [](Arena&, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Pbf>(); }};
}

}  // namespace feder
