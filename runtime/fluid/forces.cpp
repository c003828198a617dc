// Viscosity, surface tension and the damping of noise, applied to velocities.
// Viscosity: the Laplacian of the velocity as a sum over pairs (Monaghan & Gingold 1983; Monaghan 2005), the boundary
// by the integral of the same term over the solid with the velocity continued oddly through its face (Morris 1997), or
// not at all: free slip, no tangential stress at the wall.
// Tension: neighbours attract each other, strongest at half the support (Akinci, Akinci & Teschner 2013), with the
// strength that gives a sharp surface the wanted tension (Kirkwood & Buff 1949, pool.cpp): sigma is in N/m. Forces
// along the lines of pairs, so all momentum is kept. It must not have the shape of the kernel: where the density is
// held everywhere, attraction by the same kernel is the same everywhere, and there is no tension at all. The colour
// field's curvature (Brackbill 1992, Mueller 2003) was tried instead: where pressure does not pull, its noise tears the
// surface apart. The boundary does not attract: fluids with tension do not wet. Weak spot: cold particles order
// themselves; in 3D a drop of a few thousand of them is held by its own lattice and swings too little.
#include <algorithm>
#include <cmath>

#include "base/cast.h"
#include "fluid/block_sums.h"
#include "fluid/solver.h"

namespace feder {
namespace {

constexpr Real kViscousLimit = Real(0.1);  // of (support/2)^2/nu, largest time of a round; 0.125 in Morris 1997
constexpr int kMaxRounds = 64;             // in a solver substep

constexpr Real kShortest = 50;  // over the squared support: largest eigenvalue of the Laplacian, 47 to 56 by the kernel

// Of sqrt(g/d): of the decay of the shortest waves, in the plane (where a slosh loses by it) and in space.
constexpr Real kNoiseRate[2] = {Real(0.45), Real(1.2)};
constexpr Real kMaxNoiseShare = Real(0.5);  // of them, in a substep

constexpr Real kCrowd = Real(1.5);  // density over that at rest, beyond which they are damped less

// What makes the sum of Sweeps::viscous a Laplacian, times `by`.
Real laplacian_factor(const FluidPool& p, Real by) {
  const int d = p.dimension;
  if (p.kernel->radial_viscosity) return 2 * static_cast<Real>(d + 2) * by * p.slope_factor;
  const Real r2 = p.support * p.support, norm = static_cast<Real>(p.kernel->norm_viscosity[d - 2]);
  return by * p.unit * norm / (r2 * p.support * (d == 3 ? r2 : p.support));
}

void viscous_round(FluidPool& p, Boundary& boundary, Real h, StepContext& c) {
  FEDER_ASSERT(h > 0 && p.desc.viscosity > 0);
  const Real nu = p.viscous_scale * p.desc.viscosity / p.desc.density;
  const Real r2 = p.support * p.support, factor = laplacian_factor(p, nu);
  // between particles, explicit, all at once
  SweepInput in = p.sweep_input();
  in.soft = Real(1e-6) * r2;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->viscous(in, first, last, &p.extra[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.extra[i].set(h * factor * p.extra[i].vec());
  });
  // at the boundary, implicit in each contact
  const auto rub = [&](std::uint32_t i, auto&& give) {
    for (const BoundaryContact& k : p.contacts_of(i)) {
      const Real s = k.distance(p.x[i].vec()) / p.support;
      if (s >= 1) continue;
      FEDER_ASSERT(k.particle == i && k.shape < boundary.shapes.size());
      BoundaryBody& b = boundary.body_of(k);
      const Vec3 at = p.x[i].vec(), slip = p.v[i].vec() - b.velocity_at(at);
      const Vec3 along = slip - dot(slip, k.normal) * k.normal;
      const Real rate = h * nu * p.table->at(std::max(s, Real(0))).friction / (std::max(s, Real(0.05)) * r2);
      FEDER_ASSERT(!(rate < 0));
      const Vec3 change = -(rate / (1 + rate)) * along;  // implicit: never reverses the slip
      p.v[i].set(p.v[i].vec() + change);
      if (b.dynamic)
        b.push(at, -p.mass * change);
      else
        give(boundary.shapes[k.shape].body, Vec3(-p.mass * change));
    }
  };
  const auto meets_dynamic = [&](std::uint32_t i) {
    const auto contacts = p.contacts_of(i);
    return std::any_of(contacts.begin(), contacts.end(),
                       [&](const BoundaryContact& k) { return boundary.body_of(k).dynamic; });
  };
  const bool any_dynamic = !p.dynamic_contacts.empty();
  weigh_blocks(p.count, boundary, c, [&](std::uint32_t i, Vec3* impulses) {
    p.v[i].set(p.v[i].vec() + p.extra[i].vec());
    if (p.slips || (any_dynamic && meets_dynamic(i))) return;
    rub(i, [&](std::uint32_t body, const Vec3& impulse) {
      if (impulses) impulses[body] += impulse;
    });
  });
  if (p.slips) return;
  // each changes the velocities of bodies that the next one meets
  std::uint32_t last = kNone;
  for (const std::uint32_t at : p.dynamic_contacts) {
    if (p.contacts[at].particle == last) continue;
    last = p.contacts[at].particle;
    rub(last, [&](std::uint32_t body, const Vec3& impulse) { boundary.bodies[body].impulse += impulse; });
  }
}

}  // namespace

void add_viscosity(FluidPool& p, Boundary& boundary, Real h, StepContext& c) {
  const Real nu = p.viscous_scale * p.desc.viscosity / p.desc.density, unit = p.support / 2;
  const Real wanted = std::ceil(h * nu / (kViscousLimit * unit * unit));
  const int rounds = static_cast<int>(std::min(std::max(wanted, Real(1)), static_cast<Real>(kMaxRounds)));
  if (wanted > kMaxRounds && !p.warned_viscosity) {
    p.warned_viscosity = true;
    c.events->warn("fluid_viscosity",
                   "viscosity " + std::to_string(p.desc.viscosity) + " Pa s needs " +
                       std::to_string(whole_count(wanted)) + " rounds in a step, " + std::to_string(kMaxRounds) +
                       " are done: the fluid is thinner than asked for; take a larger spacing or more substeps",
                   p.object);
  }
  // beyond kMaxRounds the viscosity is what they can carry
  const Real each = wanted > kMaxRounds ? kViscousLimit * unit * unit / nu : h / static_cast<Real>(rounds);
  for (int k = 0; k < rounds; ++k) viscous_round(p, boundary, each, c);
}

void add_tension(FluidPool& p, Boundary&, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real pull = h * p.cohesion / (p.mass * p.support);
  FEDER_ASSERT(!(pull < 0));
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->cohere(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() - pull * p.move[i].vec());
  });
}

void damp_still_noise(FluidPool& p, Real h, StepContext& c) {
  const Real g = length(p.weight(c.gravity));
  if (g > 0)
    damp_noise(p, std::min(kMaxNoiseShare, h * kNoiseRate[p.dimension - 2] * std::sqrt(g / p.desc.spacing)), c);
}

void damp_noise(FluidPool& p, Real share, StepContext& c) {
  FEDER_ASSERT(share > 0 && share <= 1);
  const Real r2 = p.support * p.support, factor = laplacian_factor(p, r2 / kShortest);
  SweepInput in = p.sweep_input();
  in.soft = Real(1e-6) * r2;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->viscous(in, first, last, &p.extra[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      const Real crowd =
          std::max(Real(1), p.ratio[i] / kCrowd);  // sums grow with the density, and with them what is stable
      p.extra[i].set(factor / (crowd * crowd) * p.extra[i].vec());
    }
  });
  p.extra[p.count] = {};
  in.velocity = &p.extra[0].x;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->viscous(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() - share * factor * p.move[i].vec());
  });
}

}  // namespace feder
