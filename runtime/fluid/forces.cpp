// Damping of noise, applied to velocities.
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
  const auto inertia = [&](std::uint32_t i) { return mixture ? p.mass_of(i) : Real(1); };
  if (mixture) p.weigh(*c.jobs, [&p](std::uint32_t i) { return p.share_of(i) * p.mass_of(i); });
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
  if (mixture) p.clear_weights(*c.jobs);
}

}  // namespace feder
