// Sums over particles by several threads: each block is summed in order, and then the blocks are, so the number of
// threads does not show.
#pragma once
#include <algorithm>
#include <new>

#include "fluid/pool.h"

namespace feder {

inline std::uint32_t block_count(std::uint32_t count, JobGrain grain) {
  return count / grain.items + (count % grain.items != 0);
}

// f(first, last, sum) adds the terms of a block to a Sum, which begins at its default; Sum::add(other) adds that of the
// next block.
template <class Sum, class F>
Sum sum_ranges(std::uint32_t count, JobGrain grain, JobPool& jobs, Scratch& scratch, F&& f) {
  const Scratch::Frame frame(scratch);
  const std::uint32_t blocks = block_count(count, grain);
  Sum* sums = scratch.take<Sum>(blocks);
  jobs.for_blocks(count, grain, [&](std::uint32_t first, std::uint32_t last, int) {
    Sum sum;
    f(first, last, sum);
    new (&sums[first / grain.items]) Sum(sum);
  });
  Sum all;
  for (std::uint32_t b = 0; b < blocks; ++b) all.add(sums[b]);
  return all;
}

// The same by f(i, sum) for each term.
template <class Sum, class F>
Sum sum_blocks(std::uint32_t count, JobGrain grain, JobPool& jobs, Scratch& scratch, F&& f) {
  return sum_ranges<Sum>(count, grain, jobs, scratch, [&](std::uint32_t first, std::uint32_t last, Sum& sum) {
    for (std::uint32_t i = first; i < last; ++i) f(i, sum);
  });
}

// f(i, impulses) for each particle; it adds what the particle gives to bodies that the fluid does not move to
// impulses[body], which is null unless Boundary::weighed.
template <class F>
void weigh_blocks(std::uint32_t count, Boundary& boundary, const StepContext& c, F&& f) {
  const Scratch::Frame frame(*c.scratch);
  const std::size_t bodies = boundary.weighed ? boundary.bodies.size() : 0, blocks = block_count(count, kParticleGrain);
  Vec3* impulses = c.scratch->take<Vec3>(blocks * bodies);
  c.jobs->for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    Vec3* own = bodies > 0 ? impulses + first / kParticleGrain.items * bodies : nullptr;
    std::fill(own, own + bodies, Vec3(Vec3::Zero()));
    for (std::uint32_t i = first; i < last; ++i) f(i, own);
  });
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t n = 0; n < bodies; ++n)
      if (!boundary.bodies[n].dynamic) boundary.bodies[n].impulse += impulses[b * bodies + n];
}

}  // namespace feder
