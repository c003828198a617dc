// Weakly compressible SPH: pressure from density by Tait's equation p = k ((rho/rho0)^7 - 1), k = rho0 c^2 / 7, and
// plain forces. Monaghan 1994; Becker & Teschner, SCA 2007; pair forces in the form that follows from an energy,
// -(p_i/rho_i^2 + p_j/rho_j^2) grad W, so linear and angular momentum are kept.
// Nothing is tuned by hand: the speed of sound follows from the compression that is wanted, c^2 = max(v^2, g H,
// nu v / H) / compression (Morris, Fox & Zhu 1997), with the fluid's own speed v and height H; the own time step from
// sound, walls, acceleration, viscosity and tension. Where max_substeps do not suffice, c is lowered to what they
// can carry, and a warning says how far the fluid will be compressed.
// What flies alone asks for no sound (components.h). Where the sound rises, because something fast comes near, the
// pressure that the compression had is kept, and what it would have more goes over into pressure in the time of a free
// fall through the column: else the energy of the compression, as many times larger as c^2, would throw up what rests.
// Negative pressure is clamped to 0: the fluid does not pull (no tensile clumping, but no suction either).
// Kept between calls: the speed of sound, and of each particle the pressure that is held back. Weak spot: sound sets
// the step: 10 to 70 times more steps than pbf.
#include <algorithm>
#include <cmath>

#include "base/cast.h"
#include "fluid/components.h"
#include "fluid/solver.h"

namespace feder {
namespace {

constexpr Real kCourant = Real(0.4);      // of smoothing length over speed; Monaghan 1992
constexpr Real kForceLimit = Real(0.25);  // of sqrt(smoothing length over acceleration)
constexpr Real kSkin = Real(0.08);        // of the support: lists are kept until somebody moved by half of it

// Where particles lie on each other, pressure grows no further: bounded forces, and a fluid that comes apart.
constexpr Real kMaxRatio = Real(1.5);

// A wall throws nothing back faster than a pressure wave of the wanted compression moves the fluid, times this. What
// hits a wall faster than steps resolve is stopped by the guard deep in the wall's pressure, as if it were compressed:
// it would come back faster than it came, and raise the speed of sound, and come back faster still.
constexpr Real kLeave = 1;

Real compression_of(const FluidPool& p) { return p.desc.compression > 0 ? p.desc.compression : Real(0.01); }

class Wcsph final : public FluidSolver {
 public:
  void add_passes(StepPlan& plan) override {
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
  void refresh(FluidPool& p, StepContext& c);
  void find_contacts(FluidPool& p, StepContext& c);
  void accelerate(FluidPool& p, StepContext& c);
  Real h_ = 0;  // s, of a fluid substep
  static Real tait(Real density, Real sound, Real ratio) {
    ratio = std::min(ratio, kMaxRatio);
    const Real r2 = ratio * ratio, r7 = r2 * r2 * r2 * ratio;
    return std::max(Real(0), density * sound * sound / 7 * (r7 - 1));
  }
};

void Wcsph::choose_steps(StepContext& c) {
  for (FluidPool* p : pools)
    if (p->count > 0 && !p->frozen) want_steps(*p, wanted_steps(*p, c), c);
}

void Wcsph::begin(StepContext& c) {
  FEDER_ASSERT(c.inner.index < c.inner.count);
  h_ = c.h / static_cast<Real>(c.inner.count);
  if (c.inner.index > 0) return;
  boundary->move_to(0);
  each(c, [&](FluidPool& p) { p.lists_stale = true; });
}

void Wcsph::find_neighbors(StepContext& c) {
  each(c, [&](FluidPool& p) { refresh(p, c), ++p.steps; });
}

void Wcsph::press(StepContext& c) {
  each(c, [&](FluidPool& p) { accelerate(p, c); });
}

void Wcsph::project(StepContext& c) {
  bool any = false;
  each(c, [&](FluidPool&) { any = true; });
  if (!any) return;
  boundary->move_to(h_ * static_cast<Real>(c.inner.index + 1));
  each(c, [&](FluidPool& p) { p.project_out(*boundary); });
}

int Wcsph::wanted_steps(FluidPool& p, StepContext& c) {
  const Vec3 gravity = p.desc.gravity_scale * c.gravity;
  const Real g = length(gravity), length_unit = p.support / 2;
  Real low = kInfinity, high = -kInfinity;
  FlowScales flow;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const Vec3 v = p.v[i].vec();
    flow.speed2 = std::max(flow.speed2, dot(v, v));
    const Real s = dot(gravity, p.x[i].vec());
    low = std::min(low, s), high = std::max(high, s);
  }
  flow.head = high - low;
  Real boundary_speed = 0;
  for (const BoundaryBody& b : boundary->bodies) boundary_speed = std::max(boundary_speed, length(b.velocity));
  const Real tension = p.inward / p.desc.density;
  const Real held = std::max({boundary_speed * boundary_speed, g * p.desc.spacing, tension});
  p.sort_by_cell(kSkin * p.support);  // as the lists of this substep want them: who is apart keeps its place
  if (std::max(flow.speed2, flow.head) > held)
    flow = flow_scales(p, *boundary, c);
  else
    std::fill(p.apart.begin(), p.apart.begin() + p.count, std::uint8_t(0));
  // the bodies' pressure counts like a column of the same weight: what they press on is not known before
  const Real gh = flow.head, nu = p.desc.viscosity / p.desc.density;
  const Real speed = std::sqrt(flow.speed2), height = g > 0 ? gh / g + p.desc.spacing : p.desc.spacing;
  const Real floor2 = std::max({flow.speed2, gh, nu * speed / height, held});
  Real sound = std::sqrt(floor2 / compression_of(p));

  // a body lighter than the particles that press on it swings faster than they do
  Real light = 1;
  bool any = false;
  for (const BoundaryBody& b : boundary->bodies) any = any || (b.dynamic && !b.inv_mass.isZero(0));
  if (any) find_contacts(p, c);
  for (const BoundaryBody& b : boundary->bodies)
    if (b.dynamic) light = std::max(light, Real(0.1) * p.mass * b.inv_mass.maxCoeff() * b.contact_weight * p.support);
  const Real others = std::max(speed, boundary_speed);
  Real step = kCourant * length_unit / (std::sqrt(light) * sound + others);
  step = std::min(step, g > 0 ? kForceLimit * std::sqrt(length_unit / g) : step);
  if (p.desc.surface_tension > 0)
    step = std::min(step, Real(0.4) * std::sqrt(p.desc.density * length_unit * length_unit * length_unit /
                                                (2 * kPi * p.desc.surface_tension)));
  const Real wanted = std::ceil(c.h / step);
  const int steps = static_cast<int>(std::min(std::max(Real(1), wanted), static_cast<Real>(p.desc.max_substeps)));
  if (wanted > static_cast<Real>(p.desc.max_substeps)) {
    // the sound that the budget carries
    const Real carried = std::max((kCourant * length_unit * static_cast<Real>(steps) / c.h - others) / std::sqrt(light),
                                  Real(0.1) * sound / 10);
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
  FEDER_ASSERT(!(sound < 0) && light >= 1);
  p.sound_before = p.sound, p.sound = sound;
  p.settling = g > 0 ? std::sqrt(height / g) : height / std::sqrt(floor2);
  return steps;
}

// Lists and wall contacts for the coming step.
void Wcsph::refresh(FluidPool& p, StepContext& c) {
  const Real skin = kSkin * p.support;
  if (!p.lists_stale) {
    Real far = 0;
    for (std::uint32_t i = 0; i < p.count; ++i) {
      const Vec3 d = p.x[i].vec() - p.swap4[i].vec();
      if (!p.apart[i]) far = std::max(far, dot(d, d));
    }
    p.lists_stale = far > skin * skin / 4;
  }
  bool moving = p.lists_stale;  // planes of walls at rest hold as long as the lists
  for (const BoundaryBody& b : boundary->bodies)
    moving = moving || b.dynamic || !b.velocity.isZero(0) || !b.angular_velocity.isZero(0);
  if (p.lists_stale) {
    if (c.inner.index > 0) {
      p.sort_by_cell(skin);
      std::fill(p.apart.begin(), p.apart.begin() + p.count, std::uint8_t(0));  // they have changed places
    }
    p.find_neighbors(*c.jobs, skin);
    std::copy(p.x.begin(), p.x.begin() + p.count, p.swap4.begin());
    p.lists_stale = false;
  }
  if (moving) find_contacts(p, c);
}

// Wall contacts where the particles are, good for the rest of the substep of the world.
void Wcsph::find_contacts(FluidPool& p, StepContext& c) {
  std::copy(p.x.begin(), p.x.begin() + p.count, p.start.begin());
  p.find_contacts(*c.jobs, *boundary, c.h, c.gravity, true);
  for (BoundaryBody& b : boundary->bodies) b.contact_weight = 0;
  p.share_bodies(*boundary);
}

void Wcsph::accelerate(FluidPool& p, StepContext& c) {
  const Real h = h_;
  p.find_ratios(*c.jobs);
  // where the sound has risen, pressure is what it was
  const bool risen = c.inner.index == 0 && p.sound_before > 0 && p.sound > p.sound_before;
  const Real stay = p.settling / (p.settling + h);
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const Real r = std::min(p.ratio[i], kMaxRatio), full = tait(p.desc.density, p.sound, r);
    Real& less = p.lambda[i];
    if (risen) less += tait(p.desc.density, p.sound_before, r) - full;
    less = full > 0 ? stay * less : Real(0);
    FEDER_ASSERT(!(less > 0));
    p.x[i].w = std::max(Real(0), full + less) / (r * r);
  }
  SweepInput in = p.sweep_input();
  const Real density = p.desc.density, factor = -p.slope_factor / density;
  in.damping = density * p.desc.artificial_viscosity * p.sound * p.support / 2;
  const Vec3 gravity = p.desc.gravity_scale * c.gravity;
  const bool damped = in.damping > 0;
  const Real leave = kLeave * compression_of(p) * p.sound;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    (damped ? p.sweeps->push_damped : p.sweeps->push)(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      Vec3 a = factor * p.move[i].vec() + gravity;
      for (BoundaryContact& k : p.contacts_of(i)) {
        FEDER_ASSERT(k.particle == i && h > 0);
        const Real d = dot(k.normal, p.x[i].vec()) - k.offset;
        const Vec3 off =
            p.v[i].vec() - boundary->bodies[boundary->shapes[k.shape].body].velocity_at(p.x[i].vec()) + h * a;
        const Real most = std::max(Real(0), (leave - dot(k.normal, off)) / h);
        const Real push = std::min(most, p.x[i].w * p.table->at(d / p.support).slope / (p.support * density));
        a += push * k.normal;
        k.impulse = push * p.mass * h;
      }
      p.move[i].set(a);
    }
  });
  for (const std::uint32_t at : p.dynamic_contacts) {
    const BoundaryContact& k = p.contacts[at];
    boundary->bodies[boundary->shapes[k.shape].body].push(p.x[k.particle].vec(), -k.impulse * k.normal);
  }
  if (boundary->weighed) p.weigh_fixed(*boundary);
}

void Wcsph::move(StepContext& c) {
  each(c, [&](FluidPool& p) {
    for (std::uint32_t i = 0; i < p.count; ++i) p.v[i].set(p.v[i].vec() + h_ * p.move[i].vec());
    if (p.desc.viscosity > 0) add_viscosity(p, *boundary, h_, c);
    if (p.desc.surface_tension > 0) add_tension(p, *boundary, h_, c);
    for (std::uint32_t i = 0; i < p.count; ++i) {
      p.x[i].set(p.x[i].vec() + h_ * p.v[i].vec());
      p.x[i].w = 0;
    }
  });
}

}  // namespace

Variant<FluidSolver> fluid_wcsph() {
  return {"wcsph", "weakly compressible SPH: accurate, many small steps",
          [](Arena&, const Params&) -> std::unique_ptr<FluidSolver> { return std::make_unique<Wcsph>(); }};
}

}  // namespace feder
