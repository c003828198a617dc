// Surface tension and the damping of noise, applied to velocities.
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

constexpr Real kShortest = 50;  // over the squared support: largest eigenvalue of the Laplacian, 47 to 56 by the kernel

// Of sqrt(g/d): of the decay of the shortest waves, in the plane (where a slosh loses by it) and in space.
constexpr Real kNoiseRate[2] = {Real(0.45), Real(1.2)};
constexpr Real kMaxNoiseShare = Real(0.5);  // of them, in a substep

constexpr Real kCrowd = Real(1.5);  // density over that at rest, beyond which they are damped less

}  // namespace

namespace {

// Each fluid in turn is pulled by all, particles that lie side by side in one sweep.
void add_tension_of_mixture(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  for (std::uint32_t k = 0; k < p.phases.size(); ++k) {
    const FluidPool& own = *p.phases[k];
    const Real share = h / (own.mass * p.support);
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) p.x[i].w = share * p.pull_between(k, p.phase[i]);
    });
    c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first, end = first; i < last; i = end) {
        for (end = i + 1; end < last && p.phase[end] == p.phase[i];) ++end;
        if (p.phase[i] != k) continue;
        p.sweeps->cohere_by(in, i, end, &p.move[0].x);
        for (std::uint32_t n = i; n < end; ++n) p.v[n].set(p.v[n].vec() - p.move[n].vec());
      }
    });
  }
  c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) p.x[i].w = 0;
  });
}

}  // namespace

void add_tension(FluidPool& p, Boundary&, Real h, StepContext& c) {
  if (p.is_mixture()) return add_tension_of_mixture(p, h, c);
  const SweepInput in = p.sweep_input();
  const Real pull = h * p.cohesion / (p.mass * p.support);
  FEDER_ASSERT(!(pull < 0));
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->cohere(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() - pull * p.move[i].vec());
  });
}

void damp_still_noise(FluidPool& p, Real h, StepContext& c) {
  if (p.is_mixture() && !p.layered) return;  // it would hold drops of one fluid in the other
  const Real g = length(p.weight(c.gravity));
  if (g > 0)
    damp_noise(p, std::min(kMaxNoiseShare, h * kNoiseRate[p.dimension - 2] * std::sqrt(g / p.desc.spacing)), c);
}

void damp_noise(FluidPool& p, Real share, StepContext& c) {
  FEDER_ASSERT(share > 0 && share <= 1);
  const Real r2 = p.support * p.support, factor = laplacian_factor(p, r2 / kShortest);
  SweepInput in = p.sweep_input();
  in.soft = Real(1e-6) * r2;
  const bool mixture = p.is_mixture();  // masses are the weights: what one loses the others gain
  const auto viscous = mixture ? p.sweeps->viscous_by : p.sweeps->viscous;
  const auto weigh = [&](bool by_mass) {
    c.jobs->for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) p.x[i].w = by_mass ? p.mass_of(i) : Real(0);
    });
  };
  const auto inertia = [&](std::uint32_t i) { return mixture ? p.mass_of(i) : Real(1); };
  if (mixture) weigh(true);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    viscous(in, first, last, &p.extra[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      const Real crowd =
          std::max(Real(1), p.ratio[i] / kCrowd);  // sums grow with the density, and with them what is stable
      p.extra[i].set(factor / (crowd * crowd * inertia(i)) * p.extra[i].vec());
    }
  });
  p.extra[p.count] = {};
  in.velocity = &p.extra[0].x;
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    viscous(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i)
      p.v[i].set(p.v[i].vec() - share * factor / inertia(i) * p.move[i].vec());
  });
  if (mixture) weigh(false);
}

}  // namespace feder
