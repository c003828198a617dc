// WCSPH, weakly compressible SPH: pressure from density by Tait's equation p = k ((rho/rho0)^7 - 1), k = rho0 c^2 / 7,
// and explicit forces. Monaghan 1994; Becker & Teschner, SCA 2007, eq. 7; pair forces in the form that follows from an
// energy,
// -(p_i/rho_i^2 + p_j/rho_j^2) grad W (Monaghan 2005, eq. 3.3), so linear and angular momentum are kept.
// Motion by a leapfrog, kick-drift-kick (Verlet 1967), or by symplectic Euler: between solver substeps the half kicks
// are joined, so a leapfrog costs one more evaluation in a substep of the world.
// What takes energy, beside the fluid's own viscosity: sound by an acoustic damper, a pressure by the growth of the
// density, rho c l (d rho/dt) / rho (Sun, Pilloton, Antuono & Colagrossi 2023), which is a bulk viscosity and does not
// touch what keeps its volume; and noise of what weighs (damp_still_noise). Both keep momentum. Monaghan's artificial
// viscosity, which damps all that approaches, only where it is asked for.
// Nothing is tuned by hand: the speed of sound follows from the wanted compression, c^2 = max(v^2, g H,
// nu v / H) / compression (Morris, Fox & Zhu 1997), with the fluid's own speed v and height H; the solver substep from
// sound, boundary, acceleration, viscosity and tension. Where max_substeps do not suffice, c is lowered to what they
// carry, and a warning says how far the fluid will be compressed.
// Bodies yield to it linearly implicitly (yield_bodies.cpp), however light they are.
// Isolated particles do not count for c (components.h). Where c rises, because a fast component approaches, pressure
// first keeps its value, and the surplus that the compression would have at the new c is blended in over the time of a
// free fall through the column: else the energy of the compression, larger by the ratio of c^2, would throw up fluid at
// rest. Negative pressure is clamped to 0: the fluid does not pull (no tensile clumping, but no suction either). Kept
// between calls: the speed of sound, and of each particle the pressure that is held back (FluidPool::lambda). Weak
// spot: sound sets the step: 10 to 70 times more solver substeps than pbf.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/cast.h"
#include "fluid/block_sums.h"
#include "fluid/components.h"
#include "fluid/solver.h"
#include "fluid/yield_bodies.h"

namespace feder {
namespace {

constexpr Real kCourant = Real(0.4);      // CFL number: of smoothing length over speed; Monaghan 1992
constexpr Real kRipple = Real(0.4);       // of the time of the shortest ripple
constexpr Real kForceLimit = Real(0.25);  // of sqrt(smoothing length over acceleration)
constexpr Real kSkin = Real(0.08);        // of the support: lists are kept until a particle moved by half of it

// Density over density at rest beyond which pressure grows no further: bounded forces where particles overlap.
constexpr Real kMaxRatio = Real(1.5);

// Rebound speed from a boundary, at most, over the velocity of a pressure wave of the wanted compression. A particle
// that hits a boundary faster than solver substeps resolve is stopped by the projection deep in the boundary's
// pressure, as if it were compressed: it would rebound faster than it came, raise the speed of sound, and rebound
// faster still.
constexpr Real kMaxRebound = 1;

// Bulk viscosity of the acoustic damper over the speed of sound times the smoothing length. Of what weighs, as that
// rings when it sinks into its compression; drops that tension holds have to stay warm to yield (pool.cpp).
constexpr Real kDamper = Real(0.05);

Real compression_of(const FluidPool& p) { return p.desc.compression > 0 ? p.desc.compression : Real(0.01); }

class Wcsph final : public FluidSolver {
 public:
  void keep(FluidPool& p) const override { p.half_kicks = p.desc.integrator == "leapfrog"; }
  void add_passes(StepPlan& plan) override {
    for (FluidPool* p : pools) p->keep_listed();
    plan.add<&Wcsph::choose_steps>(Rank::fluid_choose, "wcsph substeps", Fluid::kName, this);
    plan.add<&Wcsph::begin>(Rank::fluid_predict, "wcsph begin", Fluid::kName, this);
    plan.add<&Wcsph::find_neighbors>(Rank::fluid_neighbors, "wcsph neighbors", Fluid::kName, this);
    plan.add<&Wcsph::press>(Rank::fluid_pressure, "wcsph pressure", Fluid::kName, this);
    plan.add<&Wcsph::move>(Rank::fluid_move, "wcsph move", Fluid::kName, this);
    plan.add<&Wcsph::project>(Rank::fluid_project, "wcsph non-penetration", Fluid::kName, this);
  }
  Real pressure(const FluidPool& p, std::uint32_t i) const override {
    return std::max(Real(0), tait(p.desc.density, p.sound, p.ratio[i]) + p.lambda[i]) - p.inward;
  }

 private:
  void choose_steps(StepContext& c);
  int wanted_steps(FluidPool& p, StepContext& c);
  void begin(StepContext& c);
  void find_neighbors(StepContext& c);
  void press(StepContext& c);
  void move(StepContext& c);
  void project(StepContext& c);
  void refresh(FluidPool& p, bool sorted, StepContext& c);
  void find_contacts(FluidPool& p, StepContext& c);
  void find_pressures(FluidPool& p, Real h, bool first, StepContext& c);
  void accelerate(FluidPool& p, Real h, Real lead, StepContext& c);
  void kick(FluidPool& p, Real h, StepContext& c);
  // s, of the kick before the motion of a solver substep. Between two of them a leapfrog's are joined to a whole one.
  Real kick_time(const FluidPool& p, const StepContext& c) const {
    return p.half_kicks && c.inner.index == 0 ? h_ / 2 : h_;
  }
  Real h_ = 0;  // s, of a fluid substep
  static Real tait(Real density, Real sound, Real ratio) { return tait(density * sound * sound / 7, ratio); }
  static Real tait(Real stiffness, Real ratio) {
    ratio = std::min(ratio, kMaxRatio);
    const Real r2 = ratio * ratio, r7 = r2 * r2 * r2 * ratio;
    return std::max(Real(0), stiffness * (r7 - 1));
  }
};

void Wcsph::choose_steps(StepContext& c) {
  for (FluidPool* p : pools)
    if (p->active()) want_steps(*p, wanted_steps(*p, c), c);
}

void Wcsph::begin(StepContext& c) {
  FEDER_ASSERT(c.inner.index < c.inner.count);
  h_ = c.h / static_cast<Real>(c.inner.count);
  if (c.inner.index > 0) return;
  boundary->move_to(0);
  each(c, [&](FluidPool& p) { p.lists_stale = true; });
}

void Wcsph::find_neighbors(StepContext& c) {
  each(c, [&](FluidPool& p) { refresh(p, c.inner.index == 0, c), ++p.steps; });
}

void Wcsph::press(StepContext& c) {
  each(c, [&](FluidPool& p) {
    const Real h = kick_time(p, c);
    find_pressures(p, h, c.inner.index == 0, c);
    if (c.inner.index == 0) damp_still_noise(p, c.h, c);
    accelerate(p, h, h_ * static_cast<Real>(c.inner.index + 1), c);
  });
}

void Wcsph::project(StepContext& c) {
  bool any = false;
  each(c, [&](FluidPool&) { any = true; });
  if (!any) return;
  boundary->move_to(h_ * static_cast<Real>(c.inner.index + 1));
  each(c, [&](FluidPool& p) {
    p.project_out(*boundary, *c.jobs);
    if (!p.half_kicks || !c.inner.last()) return;
    refresh(p, false, c);
    find_pressures(p, h_ / 2, false, c), accelerate(p, h_ / 2, c.h, c), kick(p, h_ / 2, c);
  });
}

int Wcsph::wanted_steps(FluidPool& p, StepContext& c) {
  const Vec3 gravity = p.weight(c.gravity);
  const Real g = length(gravity), length_unit = p.support / 2;
  // speed and height of the fluid as one component, as an upper bound
  struct Extremes {
    Real speed2 = 0, low = kInfinity, high = -kInfinity;
    void add(const Extremes& e) {
      speed2 = std::max(speed2, e.speed2), low = std::min(low, e.low), high = std::max(high, e.high);
    }
  };
  const Extremes whole =
      sum_blocks<Extremes>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Extremes& e) {
        const Vec3 v = p.v[i].vec();
        const Real s = dot(gravity, p.x[i].vec());
        e.add({dot(v, v), s, s});
      });
  FlowScales flow;
  flow.speed2 = whole.speed2, flow.head = whole.high - whole.low + p.squeeze;
  Real boundary_speed = 0;
  for (const BoundaryBody& b : boundary->bodies) boundary_speed = std::max(boundary_speed, length(b.velocity));
  const Real tension = p.inward / p.desc.density;
  // components only where they can lower the speed of sound
  const Real held = std::max({boundary_speed * boundary_speed, g * p.desc.spacing, tension});
  p.sort_by_cell(*c.jobs,
                 kSkin * p.support);  // as the lists of this substep want them: isolated particles keep their index
  if (std::max(flow.speed2, flow.head) > held)
    flow = flow_scales(p, *boundary, c);
  else
    std::fill(p.isolated.begin(), p.isolated.begin() + p.count, std::uint8_t(0));
  // speed of sound
  const Real gh = flow.head, nu = p.desc.viscosity / p.desc.density;
  const Real speed = std::sqrt(flow.speed2), height = g > 0 ? (gh - p.squeeze) / g + p.desc.spacing : p.desc.spacing;
  const Real floor2 = std::max({flow.speed2, gh, nu * speed / height, held});
  Real sound = std::sqrt(floor2 / compression_of(p));

  // step
  const Real others = std::max(speed, boundary_speed);
  const Real fastest = std::sqrt(1 / p.lightest);  // sound in the lightest fluid over that in the heaviest
  Real step = kCourant * length_unit / (fastest * sound + others);
  step = std::min(step, g > 0 ? kForceLimit * std::sqrt(length_unit / g) : step);
  step = std::min(step, kRipple * capillary_time(p, length_unit));
  const Real wanted = std::ceil(c.h / step);
  const int steps = static_cast<int>(std::min(std::max(Real(1), wanted), static_cast<Real>(p.desc.max_substeps)));
  if (wanted > static_cast<Real>(p.desc.max_substeps)) {
    // the speed of sound that max_substeps carry
    const Real carried =
        std::max((kCourant * length_unit * static_cast<Real>(steps) / c.h - others) / fastest, Real(0.1) * sound / 10);
    if (!p.warned_budget) {
      p.warned_budget = true;
      const Real squeezed = compression_of(p) * (sound / carried) * (sound / carried);
      c.events->warn("fluid_budget",
                     "wcsph needs " + std::to_string(whole_count(wanted)) +
                         " steps of its own in a substep for a compression of " + std::to_string(compression_of(p)) +
                         ", max_substeps allows " + std::to_string(p.desc.max_substeps) +
                         ": expect a compression of about " + std::to_string(squeezed),
                     p.object);
    }
    sound = std::min(sound, carried);
  }
  FEDER_ASSERT(!(sound < 0));
  p.sound_before = p.sound, p.sound = sound;
  p.settling = g > 0 ? std::sqrt(height / g) : height / std::sqrt(floor2);
  return steps;
}

// Neighbour lists and boundary contacts for the coming solver substep.
void Wcsph::refresh(FluidPool& p, bool sorted, StepContext& c) {
  const Real skin = kSkin * p.support;
  if (!p.lists_stale) {
    std::atomic<bool> stale{false};
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      Real far = 0;
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3 d = p.x[i].vec() - p.listed_at[i].vec();
        far = std::max(far, p.isolated[i] ? Real(0) : dot(d, d));
      }
      if (far > skin * skin / 4) stale.store(true, std::memory_order_relaxed);
    });
    p.lists_stale = stale.load();
  }
  // contact planes at bodies at rest stay valid as long as the lists
  bool moving = p.lists_stale;
  for (const BoundaryBody& b : boundary->bodies)
    moving = moving || b.dynamic || !b.velocity.isZero(0) || !b.angular_velocity.isZero(0);
  if (p.lists_stale) {
    if (!sorted) {
      p.sort_by_cell(*c.jobs, skin);
      std::fill(p.isolated.begin(), p.isolated.begin() + p.count, std::uint8_t(0));  // by the order before the sort
    }
    p.find_neighbors(*c.jobs, skin);
    p.copy(p.x, p.listed_at, *c.jobs);
    p.lists_stale = false;
  }
  if (moving) find_contacts(p, c);
}

// Boundary contacts at the present positions, valid for the rest of the substep of the world.
void Wcsph::find_contacts(FluidPool& p, StepContext& c) {
  p.copy(p.x, p.start, *c.jobs);
  p.find_contacts(*c.jobs, *boundary, c.h, c.gravity, true);
  for (BoundaryBody& b : boundary->bodies) b.contact_weight = 0;
  p.share_bodies(*boundary);
}

// Pressure over squared density, as weights of the sweep; where the speed of sound has risen, pressure keeps its value.
void Wcsph::find_pressures(FluidPool& p, Real h, bool first, StepContext& c) {
  // `squares` is free here: ratios of the last solver substep
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t begin, std::uint32_t end, int) {
    std::copy(p.ratio.begin() + begin, p.ratio.begin() + end, p.squares.begin() + begin);
  });
  p.find_ratios(*boundary, *c.jobs);
  const bool weighs = !p.weight(c.gravity).isZero(0);
  const Real damper =
      first || !weighs ? Real(0) : kDamper * std::sqrt(p.lightest) * p.desc.density * p.sound * (p.support / 2) / h_;
  const bool mixture = p.is_mixture();
  const bool risen = first && p.sound_before > 0 && (mixture ? p.sound != p.sound_before : p.sound > p.sound_before);
  const Real stay = p.settling / (p.settling + h);
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t begin, std::uint32_t end, int) {
    if (risen)
      for (std::uint32_t i = begin; i < end; ++i) {
        const Real r = std::min(p.ratio[i], kMaxRatio);
        p.lambda[i] += tait(p.desc.density, p.sound_before, r) - tait(p.desc.density, p.sound, r);
      }
    // several particles at a time, as all of this lies in rows of its own
    const Real stiffness = p.desc.density * p.sound * p.sound / 7;
    const Real* ratio = p.ratio.data();
    const Real* before = p.squares.data();
    Real *lambda = p.lambda.data(), *weight = p.next_weight.data();
    for (std::uint32_t i = begin; i < end; ++i) {
      const Real r = std::min(ratio[i], kMaxRatio), full = tait(stiffness, r);
      const Real less = full > 0 ? stay * lambda[i] : Real(0);
      FEDER_ASSERT(!(less > 0) || mixture);
      lambda[i] = less;
      const Real damped = clamp(damper * (r - std::min(before[i], kMaxRatio)), -full, full);
      weight[i] = std::max(Real(0), full + less + damped) / (r * r);
    }
  });
}

// Accelerations by neighbours and by the boundary, for a kick of h seconds. `lead`: s, for which a change of a body's
// velocity counts for its pose where forces are found next.
void Wcsph::accelerate(FluidPool& p, Real h, Real lead, StepContext& c) {
  SweepInput in = p.sweep_input();
  const Real density = p.desc.density;
  in.damping = density * p.desc.artificial_viscosity * p.sound * p.support / 2;
  const bool damped = in.damping > 0;
  const Real rebound = kMaxRebound * compression_of(p) * p.sound;
  p.weigh(*c.jobs, [&p](std::uint32_t i) { return p.share_of(i) * p.next_weight[i]; });
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    (damped ? p.sweeps->push_damped : p.sweeps->push)(in, first, last, &p.move[0].x);
    if (p.uneven())
      for (std::uint32_t i = first; i < last; ++i) p.move[i].set(p.move[i].vec() + p.next_weight[i] * p.skew[i].vec());
    for (std::uint32_t i = first; i < last; ++i) {
      const FluidDesc& own = p.fluid_of(i).desc;
      const Real by = p.uneven() ? p.slope_factor * p.share[i] * p.volume / p.mass_of(i) : p.slope_factor / own.density;
      Vec3 a = -by * p.move[i].vec() + own.gravity_scale * c.gravity;
      for (BoundaryContact& k : p.contacts_of(i)) {
        FEDER_ASSERT(k.particle == i && h > 0);
        const Real d = k.distance(p.x[i].vec());
        // velocity relative to the body after this step without the push: limits the rebound
        const Vec3 off = p.v[i].vec() - boundary->body_of(k).velocity_at(p.x[i].vec()) + h * a;
        const Real most = std::max(Real(0), (rebound - dot(k.normal, off)) / h);
        const Real push =
            std::min(most, p.next_weight[i] * p.table_of(i).at(d / p.support).slope / (p.support * own.density));
        a += push * k.normal;
        k.impulse = push * p.mass_of(i) * h;
      }
      p.move[i].set(a);
    }
  });
  // opposite impulses on bodies, once they yield
  if (!p.dynamic_contacts.empty()) yield_bodies(p, *boundary, h, lead, c);
  for (const std::uint32_t at : p.dynamic_contacts) {
    const BoundaryContact& k = p.contacts[at];
    boundary->body_of(k).push(p.x[k.particle].vec(), -k.impulse * k.normal);
  }
  if (boundary->weighed) p.weigh_fixed(*boundary, c);
}

void Wcsph::move(StepContext& c) {
  each(c, [&](FluidPool& p) {
    kick(p, kick_time(p, c), c);
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) p.x[i].set(p.x[i].vec() + h_ * p.v[i].vec());
    });
  });
}

// Changes velocities for h seconds by the accelerations in `move`, by viscosity and by tension.
void Wcsph::kick(FluidPool& p, Real h, StepContext& c) {
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() + h * p.move[i].vec());
  });
  if (p.desc.viscosity > 0) add_viscosity(p, *boundary, h, c);
  if (has_tension(p)) add_tension(p, *boundary, h, c);
  if (p.desc.vorticity > 0) confine_vorticity(p, h, c);
  p.clear_weights(*c.jobs);
}

}  // namespace

Variant<FluidSolver> fluid_wcsph() {
  return {"wcsph", "weakly compressible SPH: accurate, many small steps",
          [](Arena&, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Wcsph>(); }};
}

}  // namespace feder
