// Vorticity confinement (Steinhoff & Underhill 1994; for particles Macklin & Mueller 2013): along N x omega, with N
// where the vorticity omega grows, for epsilon d |N x omega| in m/s^2. Eddies that numerical viscosity eats go on
// turning. The mean of the accelerations is taken off, so that momentum stays. Kept between calls: nothing. Weak spot:
// it adds energy, and angular momentum with it, by no law of nature.
#include <algorithm>
#include <cmath>

#include "fluid/block_sums.h"
#include "fluid/solver.h"

namespace feder {
namespace {

struct Kicks {
  double momentum[3] = {0, 0, 0}, mass = 0, work = 0;
  void add(const Kicks& k) {
    for (int n = 0; n < 3; ++n) momentum[n] += k.momentum[n];
    mass += k.mass, work += k.work;
  }
};

}  // namespace

void confine_vorticity(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const auto each_block = [&](auto&& f) {
    c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) { f(first, last); });
  };
  each_block([&](std::uint32_t first, std::uint32_t last) {
    p.sweeps->curl(in, first, last, &p.extra[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      p.extra[i].set(p.slope_factor * p.share_of(i) * p.extra[i].vec());
      p.next_weight[i] = length(p.extra[i].vec());
    }
  });
  p.weigh(*c.jobs, [&](std::uint32_t i) { return p.next_weight[i]; });
  each_block([&](std::uint32_t first, std::uint32_t last) {
    p.sweeps->climb(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      const Vec3 towards = normalized_or(p.move[i].vec(), Vec3::Zero());
      const Real by = h * p.fluid_of(i).desc.vorticity * p.desc.spacing;
      p.move[i].set(by * cross(towards, p.extra[i].vec()));
    }
  });
  p.clear_weights(*c.jobs);
  const Kicks all = sum_blocks<Kicks>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Kicks& sum) {
    const double mass = static_cast<double>(p.mass_of(i));
    for (int k = 0; k < 3; ++k) sum.momentum[k] += mass * static_cast<double>(p.move[i].vec()[k]);
    sum.mass += mass;
  });
  Vec3 mean;
  for (int k = 0; k < 3; ++k) mean[k] = static_cast<Real>(all.momentum[k] / all.mass);
  const Kicks done = sum_blocks<Kicks>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Kicks& sum) {
    const Vec3 by = p.move[i].vec() - mean, v = p.v[i].vec();
    sum.work += static_cast<double>(p.mass_of(i) * dot(by, Vec3(v + by / 2)));
    p.v[i].set(v + by);
  });
  p.worked += std::max(0.0, done.work);
}

}  // namespace feder
