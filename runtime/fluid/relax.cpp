// Relaxation of new particles before they move: where a fill lies on another, on a body, or on a lattice that does not
// fit between its boundaries, the fluid would burst at once. Only positions are corrected, by Jacobi steps of the
// density constraint as in pbf.cpp with momentum (Polyak 1964), each of at most a fifth of a spacing; velocities and
// bodies stay as they are. A lattice that fits is left as it is. Kept between calls: nothing. Weak spot: fluid without
// room (a closed box that is overfull) stays too dense and is left to the solver, as are thousands of particles in one
// position.
#include <algorithm>
#include <cmath>
#include <string>

#include "fluid/block_sums.h"
#include "fluid/impl.h"

namespace feder {
namespace {

constexpr int kMaxRounds = 300;
constexpr int kPatience = 40;           // rounds without progress, before it ends
constexpr Real kCarry = Real(0.85);     // of the last move into the next (Polyak's heavy ball): room spreads far sooner
constexpr Real kAllowed = Real(0.02);   // excess of density that is left
constexpr Real kHopeless = 5;           // excess that rounds of a fifth of a spacing could not remove
constexpr Real kRelax = Real(0.5);      // 2 over the largest eigenvalue, see pbf.cpp
constexpr Real kMaxExcess = Real(0.5);  // that one round corrects
constexpr Real kMaxMove = Real(0.2);    // spacings in a round

// Multipliers of the round, m^2, for the sweep of push_apart(); returns the largest excess.
Real excess_of(FluidPool& p, const Boundary& boundary, const StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real rs = p.support * p.support * p.slope_factor * p.slope_factor;
  if (p.images) p.images->build(p, boundary, *c.jobs);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data());
    for (std::uint32_t i = first; i < last; ++i) {
      const Real crowd = p.value_factor * p.move[i].w + p.own_value;
      Vec3 open = p.slope_factor * p.move[i].vec();
      Real walled = 0, steep = 0;
      if (p.images) {
        walled = p.images->value(i), steep = p.images->squares(i), open += p.images->gradient(i);
      } else
        for (const BoundaryContact& k : p.contacts_of(i)) {
          const BoundaryTerms s = p.table->at(k.distance(p.x[i].vec()) / p.support);
          walled += s.value;
          steep += s.slope * s.slope / (p.support * p.support);
        }
      const Real slope = open.squaredNorm() + steep + rs * p.squares[i];
      const Real excess = std::min(crowd + walled - 1, kMaxExcess);
      p.ratio[i] = crowd + walled;
      p.next_weight[i] = excess > 0 ? -kRelax * excess / std::max(p.least_squares, slope) : Real(0);
    }
  });
  struct Most {
    Real value = 0;
    void add(const Most& m) { value = std::max(value, m.value); }
  };
  return sum_blocks<Most>(p.count, kParticleGrain, *c.jobs, *c.scratch,
                          [&](std::uint32_t i, Most& m) { m.value = std::max(m.value, p.ratio[i] - 1); })
      .value;
}

void push_apart(FluidPool& p, JobPool& jobs) {
  jobs.for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) p.x[i].w = p.next_weight[i];
  });
  const SweepInput in = p.sweep_input();
  const Real longest = kMaxMove * p.desc.spacing;
  if constexpr (kAsserts)
    for (std::uint32_t i = 0; i < p.count; ++i)
      FEDER_ASSERT(!(p.x[i].w > 0));  // particles are pushed apart, never together
  jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->push(in, first, last, &p.move[0].x);
    if (p.images) p.sweeps->image_push(in, p.images->input(), first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) {
      Vec3 move = p.slope_factor * p.move[i].vec();
      if (!p.images)
        for (const BoundaryContact& k : p.contacts_of(i)) {
          const Real d = k.distance(p.x[i].vec());
          move -= p.x[i].w * p.table->at(d / p.support).slope / p.support * k.normal;
        }
      move += kCarry * p.extra[i].vec();
      const Real far = length(move);
      p.move[i].set(far > longest ? Vec3(longest / far * move) : move);
    }
  });
  jobs.for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      p.x[i].set(p.x[i].vec() + p.move[i].vec());
      p.x[i].w = 0;
      p.extra[i] = p.move[i];
    }
  });
}

}  // namespace

void Fluid::Impl::relax(StepContext& c) {
  for (auto& pool : pools) {
    FluidPool& p = *pool;
    if (!p.fresh || !p.active()) continue;
    p.fresh = false;
    std::fill(p.extra.begin(), p.extra.begin() + p.count, Row4{});
    p.sort_by_cell(*c.jobs);
    Real best = kInfinity;
    for (int round = 0, since = 0; round < kMaxRounds && since < kPatience; ++round, ++since) {
      p.find_neighbors(*c.jobs, 0);
      p.copy(p.x, p.start, *c.jobs);
      p.find_contacts(*c.jobs, boundary, 0, c.gravity, true);
      const Real most = excess_of(p, boundary, c);
      if (round == 0) check_room(p, c);
      if (round == 0 && most > kHopeless)
        c.events->warn("fluid_crowded",
                       objects.describe(p.object) + ": new particles lie on each other, " +
                           std::to_string(static_cast<long long>(most)) + " times too dense: they burst",
                       p.object);
      if (most <= kAllowed || (round == 0 && most > kHopeless)) break;
      if (most < Real(0.95) * best) best = most, since = 0;
      push_apart(p, *c.jobs);
    }
  }
}

}  // namespace feder
