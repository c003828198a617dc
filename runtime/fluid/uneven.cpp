// Fluids of unlike spacings solved as one. All have the support of the widest one, so that pairs see each other alike;
// a particle counts in a density as the volume that it stands for, over that of the widest: its `share`, by lattices,
// so that each fluid alone is at rest at its density. Sums with shares s are the same sweeps as for like ones, and a
// sum of differences:
//   sum (l_i s_j + l_j s_i) g x = s_i sum (l_i + l_j) g x + l_i sum (s_j - s_i) g x,
// so forces of pairs stay equal and opposite to the rounding of the sums. In a volume that touches
// no other spacing the second sum is zero. Weak spots: a finer fluid has up to twice the neighbours that it has alone,
// and costs so much more.
#include "fluid/pool.h"

namespace feder {

void FluidPool::keep_shares() {
  const auto whole = [this](Real spacing) {
    return lattice_sums(*kernel, dimension, static_cast<double>(support) / static_cast<double>(spacing)).whole;
  };
  for (const FluidPool* p : phases) {
    tables.push_back(std::make_unique<BoundaryTable>(
        *kernel, dimension, static_cast<double>(support) / static_cast<double>(p->desc.spacing)));
    shares.push_back(p->volume / volume * static_cast<Real>(whole(desc.spacing) / whole(p->desc.spacing)));
  }
  share.resize(x.size()), skew.resize(x.size());
}

void FluidPool::set_shares(JobPool& jobs) {
  jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) share[i] = shares[phase[i]];
  });
  share[count] = 1;
}

void FluidPool::find_skew(JobPool& jobs) {
  FEDER_ASSERT(uneven());
  weigh(jobs, [this](std::uint32_t i) { return share[i]; });
  const SweepInput in = sweep_input();
  jobs.for_blocks(count, kFluidGrain,
                  [&](std::uint32_t first, std::uint32_t last, int) { sweeps->climb(in, first, last, &skew[0].x); });
}

// Of the positions in in.velocity. With weights w, push_from sums (w_i + w_j) g y; so
//   sum (s_j - s_i) g y = sum (s_i + s_j) g y - 2 s_i sum g y.
void FluidPool::find_skew_from(const SweepInput& in, JobPool& jobs) {
  const auto sums = [&](auto&& weight, Array<Row4>& out) {
    jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) swap1[i] = x[i].w;
    });
    weigh(jobs, weight);
    jobs.for_blocks(count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      sweeps->push_from(in, first, last, &out[0].x);
    });
    weigh(jobs, [this](std::uint32_t i) { return swap1[i]; });
  };
  sums([this](std::uint32_t i) { return share[i]; }, skew);
  sums([](std::uint32_t) { return Real(0.5); }, move);
  jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) skew[i].set(skew[i].vec() - 2 * share[i] * move[i].vec());
  });
}

void FluidPool::even_slopes(std::uint32_t first, std::uint32_t last) {
  if (!uneven()) return;
  for (std::uint32_t i = first; i < last; ++i) move[i].set(share[i] * move[i].vec() + skew[i].vec());
}

void FluidPool::even_push(std::uint32_t first, std::uint32_t last) {
  if (!uneven()) return;
  for (std::uint32_t i = first; i < last; ++i) move[i].set(share[i] * move[i].vec() + x[i].w * skew[i].vec());
}

void FluidPool::share_out(const Array<Row4>& from, Array<Row4>& to, JobPool& jobs) const {
  FEDER_ASSERT(uneven() && to.size() > count);
  jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) to[i].set(share[i] * from[i].vec());
  });
  to[count] = {};
}

}  // namespace feder
