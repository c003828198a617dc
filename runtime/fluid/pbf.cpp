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
// Kept between calls: nothing; lambda stays for questions. (Keeping it as a warm start makes it the integral of the
// error in density, which swings for seconds.) Weak spot: few iterations leave deep columns compressed, by about g h^2
// N^2 / (2 n^2 d) for N layers and n iterations; pressure waves are damped.
#include <algorithm>
#include <cmath>

#include "fluid/solver.h"

namespace feder {
namespace {

constexpr double kSpectrum = 4;          // no eigenvalue of the scaled system is larger: 2.8 to 3.5 on lattices
constexpr double kDamping = 0.1;         // how far the largest eigenvalues are damped beyond holding them
constexpr Real kMostExcess = Real(0.5);  // of particles over each other that one iteration answers to: bounds their way
constexpr Real kMostWall = 1;            // of walls; likewise

// Of iteration k of n: long and short ones in turn, so that what a long one throws up a short one takes back.
Real step_length(int k, int n) {
  const int root = k % 2 == 0 ? n / 2 + k / 2 : k / 2;
  const double angle = 3.14159265358979323846 * (2 * root + 1) / (2 * n);
  return static_cast<Real>(2 / (kSpectrum * (1 + kDamping - (1 - kDamping) * sin_cos_cos(angle))));
}

class Pbf final : public FluidSolver {
 public:
  void add_rows(StepPlan& plan) override {
    plan.add<&Pbf::predict>(Stage::advance, When::each_substep, 24, "predict and sort", Fluid::kName, this);
    plan.add<&Pbf::search>(Stage::advance, When::each_substep, 25, "neighbors", Fluid::kName, this);
    plan.add<&Pbf::meet_walls>(Stage::advance, When::each_substep, 26, "wall contacts", Fluid::kName, this);
    plan.add<&Pbf::solve>(Stage::advance, When::each_substep, 27, "density", Fluid::kName, this);
    plan.add<&Pbf::rub>(Stage::advance, When::each_substep, 28, "friction and tension", Fluid::kName, this);
  }
  Real pressure(const FluidPool& p, std::uint32_t i) const override {
    if (!(p.last_h > 0)) return 0;
    const Real r2 = p.ratio[i] * p.ratio[i];
    return -r2 * p.lambda[i] / (p.last_h * p.last_h * p.volume) - p.inward;
  }

 private:
  void predict(StepContext& c);
  void search(StepContext& c);
  void meet_walls(StepContext& c);
  void solve(StepContext& c);
  void rub(StepContext& c);
  void correct(FluidPool& p, bool first_round, Real relax, StepContext& c);
  void displace(FluidPool& p, StepContext& c);
  Real distance(const FluidPool& p, const WallContact& k, Real h) const;
  template <class F>
  void each(F&& f) {
    for (FluidPool* p : pools)
      if (p->count > 0 && !p->frozen) f(*p);
  }
};

void Pbf::predict(StepContext& c) {
  each([&](FluidPool& p) {
    const Vec3 kick = c.h * p.desc.gravity_scale * c.gravity;
    c.jobs->for_blocks(p.count, 4 * kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        p.start[i] = p.x[i];
        const Vec3 v = p.v[i].vec() + kick;
        p.v[i].set(v);
        p.x[i].set(p.x[i].vec() + c.h * v);
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
    p.find_contacts(*c.jobs, *walls, c.h, c.gravity, true);
    p.share_bodies(*walls);
  });
}

// From the plane, which has gone with its body since the start of the substep.
Real Pbf::distance(const FluidPool& p, const WallContact& k, Real h) const {
  const Vec3 x = p.x[k.particle].vec();
  const Real d = dot(k.normal, x) - k.offset;
  const WallBody& b = walls->bodies[walls->list[k.wall].body];
  return d - h * dot(k.normal, b.velocity_at(x));
}

void Pbf::solve(StepContext& c) {
  each([&](FluidPool& p) {
    std::fill(p.lambda.begin(), p.lambda.begin() + p.count, Real(0));
    for (int k = 0; k < p.desc.iterations; ++k) {
      correct(p, k == 0, step_length(k, p.desc.iterations), c);
      displace(p, c);
    }
    p.last_h = c.h;
    ++p.steps;
  });
}

// One Jacobi correction of lambda; its change goes into the weight of the particle.
void Pbf::correct(FluidPool& p, bool first_round, Real relax, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real inv_mass = 1 / p.mass, rs = p.support * p.support * p.slope_factor * p.slope_factor;
  const Real compliance = p.desc.stiffness > 0 ? 1 / (p.desc.stiffness * p.volume * c.h * c.h) : Real(0);
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
        const WallSample s = p.table->at(distance(p, k, c.h) / p.support);
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
  const Real inv_mass = 1 / p.mass, rate = 1 / c.h;
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
        const Real push = -p.x[i].w * p.table->at(distance(p, k, c.h) / p.support).slope / p.support;
        move += push * k.normal;
        k.impulse = push / c.h;
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
    if (p.desc.viscosity > 0) add_viscosity(p, *walls, c.h, c);
    if (p.desc.surface_tension > 0) add_tension(p, *walls, c.h, c);
  });
}

}  // namespace

Variant<FluidSolver> fluid_pbf() {
  return {"pbf", "position based, with compliance: large steps, damps",
          [](Arena&, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Pbf>(); }};
}

}  // namespace feder
