// Position based fluids: every particle has the constraint C = density / rest density - 1 <= 0, and a substep moves
// predicted positions until the constraints hold. Macklin & Mueller, "Position Based Fluids", TOG 2013 (eq. 1, 6-11),
// with the compliance of XPBD (Macklin, Mueller & Chentanez 2016): lambda has the unit kg m^2, and -lambda/(h^2 V) is
// the pressure. Differences:
//  - the iterations of a substep are Jacobi steps accelerated by Chebyshev's semi-iteration in three terms (Golub &
//  Varga
//    1961): n of them hold a deep column as well as n^2 plain ones. Unlike with steps of unequal length (the roots of
//    the same polynomial) no iteration amplifies a mode, so a clamp in between does little harm. Where the excess grows
//    from one iteration to the next all the same, the rest are plain Jacobi steps;
//  - lambda is clamped to pressure (p >= 0): the fluid does not pull, so it neither hangs on boundaries nor holds
//  suction;
//    and to what pushes a particle by a few spacings in a substep, which bounds the speed that a correction leaves. A
//    bound on the multiplier acts on both sides of each pair, so momentum is kept;
//  - the boundary enters by a function of the distance (sph/boundary_table.h), and bodies move with the iterations.
// All particles move at once from the same positions, so order and threads do not matter. A body in contact with many
// particles is split between them (Tonge, Benevolenski & Voroshilov, "Mass Splitting", TOG 2012).
// A substep of the world is divided into solver substeps where particles would pass each other or a column would be
// crushed, which no number of iterations prevents: by the CFL number of the fluid and the boundary near it, and by the
// load Q = g h^2 H / d^2 of a column, the displacement, in spacings, that its pressure gives a particle in a substep. n
// iterations make of a residual that they hardly change a multiplier of n^2 / 5 times it, over the diagonal: they leave
// a compression of about 5 s Q / n^2 at the ground, s the squared gradients of a density on a lattice (0.12 in the
// plane, 0.42 in space). And they keep the lattice up to Q ~ 0.17 n (measured in columns of 8 to 200 layers, with 1 to
// 32 iterations); beyond that it buckles beside the boundary. A warning says when the substeps do not suffice, and when
// the fluid is denser than wanted all the same. Kept between calls: nothing; lambda stays for queries. (As a warm start
// it would be the integral of the error in density, which oscillates for seconds.) Weak spot: pressure waves are
// damped.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "fluid/block_sums.h"
#include "fluid/components.h"
#include "fluid/solver.h"

namespace feder {
namespace {

constexpr double kSpectrum = 4.8;  // largest eigenvalue of the scaled system: 3.9 to 4.6 in columns at rest
constexpr Real kMaxExcess =
    Real(0.5);  // of density by particles, that one iteration corrects: bounds their displacement
constexpr Real kMaxBoundaryExcess = 1;  // likewise of the boundary
constexpr Real kMaxTravel = 1;          // CFL number: spacings that particles or bodies move in a solver substep
constexpr Real kRippled = Real(0.5);    // of capillary_time, longest substep: with 1 drops burst at walls that attract
constexpr Real kMaxStrain =
    Real(0.03);                         // compression at the ground of a column at rest that a solver substep may leave
constexpr Real kMaxLoad = Real(0.08);   // Q over iterations: half of what is stable
constexpr Real kLattice = 5;            // squared gradients on a lattice over FluidPool::least_squares
constexpr double kMaxGrowth = 1.5;      // of the residual over its least, before the iterations become plain steps
constexpr Real kMaxPush = 2;            // Q of a single particle: above a load of 1, below what makes fountains
constexpr Real kPatience = Real(0.25);  // s, for which the fluid is too dense before a warning: splashes pass

// Coefficients of Chebyshev's semi-iteration: the next change of the multipliers is `step` times the residual plus
// `carry` times the last change. After n iterations a mode of eigenvalue e is left with P(e), |P| <= 1/cosh(kDecay)
// between kSpectrum and the low end that this takes, P -> 1 below it. Over substeps, which make velocities of
// corrections, such a mode obeys z^2 - 2 P z + P = 0: it fades for -1/3 < P < 1, hence the size of kDecay.
class SemiIteration {
 public:
  explicit SemiIteration(int n) {
    FEDER_ASSERT(n >= 1);
    const double sigma = cosh(kDecay / n), shift = (sigma - 1) / (sigma + 1);
    half_ = kSpectrum * (1 - shift) / 2;
    ratio_ = sigma;
    if (n == 1) stop();  // a single one of P < -1/3 would swing
  }
  void next() {
    const double before = rho_;
    rho_ = before > 0 ? 1 / (2 * ratio_ - before) : 1 / ratio_;
    step_ = before > 0 ? 2 * rho_ / half_ : rho_ / half_;
    carry_ = rho_ * before;
    FEDER_ASSERT(rho_ > 0 && rho_ < 1 && carry_ < 1);  // else iterations would amplify errors
  }
  // From here on plain Jacobi steps, which never amplify a mode or reverse it.
  void stop() { stopped_ = true; }
  Real step() const { return static_cast<Real>(stopped_ ? 1 / kSpectrum : step_); }
  Real carry() const { return static_cast<Real>(stopped_ ? 0 : carry_); }

 private:
  static constexpr double kDecay = 1.9;
  // A series of its own: that of the C library differs between machines.
  static double cosh(double t) {
    double sum = 1, term = 1;
    for (int k = 1; k < 24; k += 2) term *= t * t / (k * (k + 1)), sum += term;
    return sum;
  }
  double half_ = 0, ratio_ = 0, rho_ = 0, step_ = 0, carry_ = 0;
  bool stopped_ = false;
};

class Pbf final : public FluidSolver {
 public:
  void add_passes(StepPlan& plan) override {
    plan.add<&Pbf::choose_steps>(Rank::fluid_choose, "choose substeps", Fluid::kName, this);
    plan.add<&Pbf::predict>(Rank::fluid_predict, "predict and sort", Fluid::kName, this);
    plan.add<&Pbf::search>(Rank::fluid_neighbors, "neighbors", Fluid::kName, this);
    plan.add<&Pbf::boundary_contacts>(Rank::fluid_boundary, "boundary contacts", Fluid::kName, this);
    plan.add<&Pbf::solve>(Rank::fluid_pressure, "density", Fluid::kName, this);
    plan.add<&Pbf::apply_viscosity>(Rank::fluid_friction, "friction and tension", Fluid::kName, this);
    plan.add<&Pbf::project>(Rank::fluid_project, "non-penetration within", Fluid::kName, this);
    plan.add<&Pbf::check_compression>(Rank::fluid_check, "compression", Fluid::kName, this);
  }
  Real pressure(const FluidPool& p, std::uint32_t i) const override {
    FEDER_ASSERT(i < p.count);
    if (!(p.last_h > 0)) return 0;
    const Real r2 = p.ratio[i] * p.ratio[i];
    return -r2 * p.lambda[i] / (p.last_h * p.last_h * p.volume) - p.inward;
  }
  bool iterates() const override { return true; }
  bool takes_stiffness() const override { return true; }
  Real most_density_ratio() const override { return 30; }  // with 60 a light layer under a heavy one bursts

 private:
  void choose_steps(StepContext& c);
  struct Wanted {
    Real travel = 1, load = 1;  // solver substeps by the CFL number and by ripples, and by the load of the column
  };
  Wanted wanted_steps(FluidPool& p, const StepContext& c) const;
  void warn_budget(FluidPool& p, Real wanted, StepContext& c) const;
  void predict(StepContext& c);
  void search(StepContext& c);
  void boundary_contacts(StepContext& c);
  void solve(StepContext& c);
  void apply_viscosity(StepContext& c);
  void project(StepContext& c) { project_within(h_, c); }
  void check_compression(StepContext& c);
  double correct(FluidPool& p, bool first_round, const SemiIteration& scheme, StepContext& c);
  void displace(FluidPool& p, StepContext& c);
  Real distance(const FluidPool& p, const BoundaryContact& k) const;
  Real h_ = 0;  // s, of a fluid substep
};

Pbf::Wanted Pbf::wanted_steps(FluidPool& p, const StepContext& c) const {
  const Real d = p.desc.spacing;
  const ColumnScales column = column_scales(p, c);
  Wanted wanted;
  wanted.travel = std::max(c.h * speed_near(p, column, *boundary, kMaxTravel * d, c) / (kMaxTravel * d),
                           c.h / (kRippled * capillary_time(p, d)));
  if (!(column.head > 0)) return wanted;
  const Real load = c.h * c.h * column.head / (d * d), iterations = static_cast<Real>(p.desc.iterations);
  const Real strain = 5 * kLattice * p.least_squares * d * d * load / (iterations * iterations);
  wanted.load = std::sqrt(std::max(load / std::min(kMaxLoad * iterations, Real(1)), strain / kMaxStrain));
  return wanted;
}

// All fluids of a group take the same.
void Pbf::choose_steps(StepContext& c) {
  for (FluidPool* p : pools) {
    if (!p->active()) continue;
    const Wanted own = wanted_steps(*p, c);
    const Real most = static_cast<Real>(p->desc.max_substeps);
    if (own.load > most) warn_budget(*p, own.load, c);
    want_steps(*p, static_cast<int>(std::ceil(std::min(std::max({own.travel, own.load, Real(1)}), most))), c);
  }
}

// Once, before the fluid bursts.
void Pbf::warn_budget(FluidPool& p, Real wanted, StepContext& c) const {
  if (p.warned_budget) return;
  p.warned_budget = true;
  c.events->warn("fluid_budget",
                 "pbf needs " + std::to_string(static_cast<long long>(std::ceil(wanted))) +
                     " steps of its own in a substep to carry the weight of its column with " +
                     std::to_string(p.desc.iterations) + " iterations, max_substeps allows " +
                     std::to_string(p.desc.max_substeps) +
                     ": it may burst; take more iterations, more substeps, a larger max_substeps or spacing",
                 p.object);
}

// Once, when the fluid stays denser than wanted after the iterations.
void Pbf::check_compression(StepContext& c) {
  for (FluidPool* pool : pools) {
    FluidPool& p = *pool;
    if (!p.active()) continue;
    struct Sum {
      double value = 0;
      void add(const Sum& s) { value += s.value; }
    };
    const Sum excess = sum_blocks<Sum>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Sum& s) {
      s.value += std::max(0.0, static_cast<double>(p.ratio[i]) - 1);
    });
    const Real mean = static_cast<Real>(excess.value / p.count);
    const Real wanted = p.desc.compression > 0 ? p.desc.compression : Real(0.05);
    p.too_dense = mean > wanted ? p.too_dense + c.h : Real(0);
    if (p.too_dense < kPatience || p.warned_budget) continue;
    p.warned_budget = true;
    c.events->warn("fluid_budget",
                   "pbf is compressed by " + std::to_string(mean) + " on average, wanted " + std::to_string(wanted) +
                       ": " + std::to_string(p.desc.iterations) +
                       " iterations do not hold it; take more of them, more substeps or a larger spacing",
                   p.object);
  }
}

void Pbf::predict(StepContext& c) {
  h_ = c.h / static_cast<Real>(c.inner.count);
  FEDER_ASSERT(h_ > 0 && h_ <= c.h);
  if (c.inner.index == 0) {
    boundary->move_to(0);
    for (BoundaryBody& b : boundary->bodies) b.contact_weight = 0;  // set by the group before
  }
  each(c, [&](FluidPool& p) {
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        p.start[i] = p.x[i];
        const Vec3 v = p.v[i].vec() + h_ * p.fluid_of(i).desc.gravity_scale * c.gravity;
        p.v[i].set(v);
        p.x[i].set(p.x[i].vec() + h_ * v);
      }
    });
    p.sort_by_cell(*c.jobs);
  });
}

void Pbf::search(StepContext& c) {
  each(c, [&](FluidPool& p) { p.find_neighbors(*c.jobs, 0); });
}

void Pbf::boundary_contacts(StepContext& c) {
  each(c, [&](FluidPool& p) {
    p.find_contacts(*c.jobs, *boundary, h_, c.gravity, true);
    p.share_bodies(*boundary);
  });
}

// Distance of a particle from its contact plane, which has moved with its body since the start of the solver substep.
Real Pbf::distance(const FluidPool& p, const BoundaryContact& k) const {
  FEDER_ASSERT(k.particle < p.count && k.shape < boundary->shapes.size());
  const Vec3 x = p.x[k.particle].vec();
  const Real d = dot(k.normal, x) - k.offset;
  const BoundaryBody& b = boundary->body_of(k);
  return d - h_ * dot(k.normal, b.velocity_at(x));
}

void Pbf::solve(StepContext& c) {
  each(c, [&](FluidPool& p) {
    std::fill(p.lambda.begin(), p.lambda.begin() + p.count, Real(0));
    SemiIteration scheme(p.desc.iterations);
    double least = kInfinity;
    for (int k = 0; k < p.desc.iterations; ++k) {
      scheme.next();
      const double residual = correct(p, k == 0, scheme, c);
      least = std::min(least, residual);
      if (residual > kMaxGrowth * least) scheme.stop();
      displace(p, c);
    }
    p.last_h = h_;
    ++p.steps, p.iterations += static_cast<std::uint64_t>(p.desc.iterations);
  });
}

// One iteration of lambda (Macklin & Mueller 2013, eq. 11, with compliance); its change becomes the weight of the
// particle in displace(). Returns the residual before it: the squared excess, in the norm that the iterations reduce,
// of particles that are too dense, or under pressure and not dense enough.
double Pbf::correct(FluidPool& p, bool first_round, const SemiIteration& scheme, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real inv_mass = 1 / p.mass, rs = p.support * p.support * p.slope_factor * p.slope_factor;
  const Real step = scheme.step(), carry = first_round ? Real(0) : scheme.carry();
  const Real least = -kMaxPush * p.lightest * p.mass * p.desc.spacing * p.desc.spacing;
  const bool mixture = p.is_mixture();
  if (p.uneven()) {
    p.find_skew(*c.jobs);
    c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      p.sweeps->values_by(in, first, last, p.sum.data());
    });
  }
  if (mixture && first_round)
    p.weigh(*c.jobs, [&p](std::uint32_t i) { return p.share_of(i) * p.share_of(i) / p.mass_of(i); });
  const Real compliance = p.desc.stiffness > 0 ? 1 / (p.desc.stiffness * p.volume * h_ * h_) : Real(0);
  const Scratch::Frame frame(*c.scratch);
  const std::uint32_t blocks = block_count(p.count, kFluidGrain);
  double* residuals = c.scratch->take<double>(blocks);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    double residual = 0;
    // density of neighbours; in the first iteration with its gradients
    if (first_round)
      p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data()), p.even_slopes(first, last);
    else if (!p.uneven())
      p.sweeps->values(in, first, last, p.sum.data());
    if (mixture && first_round) p.sweeps->squares_by(in, first, last, p.squares.data());
    for (std::uint32_t i = first; i < last; ++i) {
      const Real crowd = p.value_factor * (first_round && !p.uneven() ? p.move[i].w : p.sum[i]) +
                         p.share_of(i) * p.own_value + p.screen[i];
      // boundary: density, gradient, and the response of bodies
      Real walled = 0, shared = 0, opposed = 0;
      Vec3 wall = Vec3::Zero();
      for (const BoundaryContact& k : p.contacts_of(i)) {
        FEDER_ASSERT(k.particle == i);
        const BoundaryTerms s = p.table_of(i).at(distance(p, k) / p.support);
        walled += s.value;
        if (!first_round) continue;
        const Real slope = s.slope / p.support;
        wall -= slope * k.normal;
        opposed += slope * slope;
        const BoundaryBody& b = boundary->body_of(k);
        if (b.dynamic) shared += slope * std::max(b.contact_weight, slope) * b.response(p.x[i].vec(), k.normal);
      }
      if (first_round) {
        const Vec3 pair = p.slope_factor * p.move[i].vec();
        // diagonal of the system. Between two solids gradients cancel, but each step changes one of them against the
        // other, so the cancelled part counts
        opposed = std::max(Real(0), opposed - wall.squaredNorm());
        const Real own = (pair + wall).squaredNorm() + opposed;
        p.diagonal[i] = (mixture ? std::max(p.least_squares, own) / p.mass_of(i) + rs * p.squares[i]
                                 : inv_mass * std::max(p.least_squares, own + rs * p.squares[i])) +
                        shared;
      }
      p.ratio[i] = crowd + walled;
      const Real excess = std::min(crowd - 1, kMaxExcess) + std::min(walled, kMaxBoundaryExcess), before = p.lambda[i];
      // Chebyshev step, clamped to pressure
      const Real stiff = p.diagonal[i] / step + compliance, carried = first_round ? Real(0) : carry * p.next_weight[i];
      const Real wanted = stiff > 0 ? before + carried - (excess + compliance * before) / stiff : Real(0);
      const Real after = clamp(wanted, least, Real(0));
      p.lambda[i] = after;
      p.next_weight[i] = after - before;
      // it is too dense, or was under pressure before this round
      const double over = static_cast<double>(p.ratio[i]) - 1, share = over * over / static_cast<double>(p.diagonal[i]);
      residual += (over > 0 || after < p.next_weight[i]) && p.diagonal[i] > 0 ? share : 0.0;
    }
    residuals[first / kFluidGrain.items] = residual;
  });
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) p.x[i].w = p.next_weight[i];
  });
  const double residual = std::accumulate(residuals, residuals + blocks, 0.0);
  FEDER_ASSERT(!(residual < 0));
  return residual;
}

// Displacements of particles by the changes of lambda (Macklin & Mueller 2013, eq. 12), and opposite impulses on
// bodies.
void Pbf::displace(FluidPool& p, StepContext& c) {
  SweepInput in = p.sweep_input();
  const Real inv_mass = 1 / p.mass, rate = 1 / h_;
  const bool mixture = p.is_mixture();
  // With gradients at the start of the substep, as in SHAKE (Ryckaert et al. 1977), angular momentum is kept. With
  // those at predicted positions, pressure against cohesion would spin a drop faster and faster; pressure against
  // gravity does not spin anything, so without tension that cost is spared.
  FEDER_ASSERT(p.start.size() > p.count);
  p.start[p.count] = {};
  in.velocity = &p.start[0].x;
  const bool from_start = p.desc.surface_tension > 0;
  if (from_start && p.uneven()) p.find_skew_from(in, *c.jobs);
  const auto push_apart = from_start ? p.sweeps->push_from : p.sweeps->push;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    push_apart(in, first, last, &p.move[0].x);
    p.even_push(first, last);
    for (std::uint32_t i = first; i < last; ++i) {
      Vec3 move = p.slope_factor * p.move[i].vec();
      for (BoundaryContact& k : p.contacts_of(i)) {
        const Real push = -p.x[i].w * p.table_of(i).at(distance(p, k) / p.support).slope / p.support;
        move += push * k.normal;
        k.impulse = push / h_;
      }
      p.move[i].set((mixture ? 1 / p.mass_of(i) : inv_mass) * move);
    }
  });
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    // velocities from displacements, not from differences of positions: these are equal and opposite nearly to the last
    // bit, wherever the origin lies
    for (std::uint32_t i = first; i < last; ++i) {
      p.x[i].set(p.x[i].vec() + p.move[i].vec());
      p.v[i].set(p.v[i].vec() + rate * p.move[i].vec());
    }
  });
  for (const std::uint32_t at : p.dynamic_contacts) {
    FEDER_ASSERT(at < p.contact_first[p.count]);
    const BoundaryContact& k = p.contacts[at];
    boundary->body_of(k).push(p.start[k.particle].vec(), -k.impulse * k.normal);
  }
  if (boundary->weighed) p.weigh_fixed(*boundary, c);
}

void Pbf::apply_viscosity(StepContext& c) {
  each(c, [&](FluidPool& p) {
    p.clear_weights(*c.jobs);
    if (p.desc.viscosity > 0) add_viscosity(p, *boundary, h_, c);
    if (has_tension(p)) add_tension(p, *boundary, h_, c);
    if (p.desc.vorticity > 0) confine_vorticity(p, h_, c);
  });
}

}  // namespace

Variant<FluidSolver> fluid_pbf() {
  return {"pbf", "position based, with compliance: large steps, damps",
          [](Arena&, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Pbf>(); }};
}

}  // namespace feder
