// Surface tension and adhesion, applied to velocities. Forces along the lines of pairs, so all momentum is kept.
//  - cohesion: neighbours attract each other, strongest at half the support (Akinci, Akinci & Teschner 2013), with the
//    strength that gives a sharp surface the wanted tension (Kirkwood & Buff 1949, pool.cpp).
//    Weak spot: it presses particles together like sand, everywhere: those of dfsph and pbf order themselves to a
//    lattice that swings too little, with periods that scatter by a third, and the pressure of a drop is what that
//    lattice was left with, -2 to 10 of Laplace's. (So is the stress of the pairs, which the forces balance: -3 to 7.)
//  - color_field: an energy at the surface. What the smoothed colour field (Mueller, Charypar & Gross 2003), the share
//    of the kernel that is full, lacks to one costs K lack^3 in every particle; K is such that a flat face of a lattice
//    has the wanted energy per area. Forces are the derivatives of that energy: a potential of many bodies (as in
//    Warren 2003), which acts where the surface is and nowhere else, so that the pressure inside is Laplace's. The
//    kernel 1 - u^2 is wider than that of the densities, or particles would heal the surface by crowding there, and
//    there were no tension at all. Tried instead: the classical force along the gradient n of the field by its
//    curvature, -div n/|n| (Brackbill 1992, Mueller 2003), as the derivative of the energy |n|, with soft and smoothed
//    normals: where pressure does not pull, drops evaporate, as lone particles and lines of them have n = 0; held by a
//    share of cohesion they lose a third of their swing in half a period. Smoothing the colour twice, other powers and
//    kernels: periods scatter more. Weak spot: how far the outermost layer is crowded depends on what a solver leaves
//    (kSettled in pool.cpp): in drops that viscosity has brought to rest, whose outermost layer cannot change its
//    number, the pressure is 1.7 to 2.1 of Laplace's in the plane, 1.4 in space; and particles gather to strings unless
//    a solver keeps them apart (dfsph.cpp). What a fluid finds of another one counts as full by a share of 1 -
//    (sigma_ab / (sigma_a + sigma_b))^(1/3): a face between the two has sigma_ab, and a gap between them costs more.
//    Tried: an energy of its own of what is full of the other one, cubed: the two repel each other and part.
// The boundary attracts by the work of adhesion, sigma (1 + cos angle) (Dupre 1869, Young 1805), spread over the
// support; without one it does not attract: such fluids with tension do not wet. Weak spot: particles at a wall stick
// where they are. With the colour field a drop that spreads stops 10 to 16 degrees above an angle of 60, one that
// gathers 2 above to 14 below it; about 90 and 120 likewise.
#include <algorithm>
#include <cmath>

#include "fluid/block_sums.h"
#include "fluid/solver.h"

namespace feder {
namespace {

// f(first, last) for the particles of fluid k that lie side by side.
template <class F>
void each_run(const FluidPool& p, std::uint32_t k, StepContext& c, F&& f) {
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first, end = first; i < last; i = end) {
      for (end = i + 1; end < last && p.phase[end] == p.phase[i];) ++end;
      if (p.phase[i] == k) f(i, end);
    }
  });
}

// Each fluid in turn is pulled by all.
void cohere_mixture(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  for (std::uint32_t k = 0; k < p.phases.size(); ++k) {
    const FluidPool& own = *p.phases[k];
    const Real share = h / (own.mass * p.support);
    p.weigh(*c.jobs, [&](std::uint32_t i) { return share * p.pull_between(k, p.phase[i]); });
    each_run(p, k, c, [&](std::uint32_t first, std::uint32_t last) {
      p.sweeps->cohere_by(in, first, last, &p.move[0].x);
      for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() - p.move[i].vec());
    });
  }
  p.clear_weights(*c.jobs);
}

void cohere(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real pull = h * p.cohesion / (p.mass * p.support);
  FEDER_ASSERT(!(pull < 0));
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->cohere(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() - pull * p.move[i].vec());
  });
}

// Slope of an energy of a volume, energy share^3, by the share of its kernel that is empty, or full of something else.
Real color_slope(Real energy, Real share) { return share > 0 ? 3 * energy * share * share : Real(0); }

// Of the kernel of particle i, if `sum` is that of its neighbours. A boundary that the fluid wets fills its share.
Real lack_of(const FluidPool& p, std::uint32_t i, Real sum) {
  Real lack = 1 - p.color_unit * (p.share_of(i) + sum);
  if (p.fluid_of(i).desc.adhesion > 0)
    for (const BoundaryContact& k : p.contacts_of(i))
      lack -= color_beyond(p.dimension, k.distance(p.x[i].vec()) / p.support).value;
  return lack;
}

// Leaves the slope of the energy of a volume, Pa, by what its colour lacks, in the weights of the positions.
void find_lacks(FluidPool& p, StepContext& c) {
  const SweepInput in = p.sweep_input();
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->colors(in, first, last, p.sum.data());
    for (std::uint32_t i = first; i < last; ++i)
      p.next_weight[i] = color_slope(p.color_energy, lack_of(p, i, p.sum[i]));
  });
  p.weigh(*c.jobs, [&](std::uint32_t i) { return p.next_weight[i]; });
}

void draw_in(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const Real by = h * p.color_unit / (p.desc.density * p.support * p.support);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    p.sweeps->draw(in, first, last, &p.move[0].x);
    for (std::uint32_t i = first; i < last; ++i) p.v[i].set(p.v[i].vec() + by * p.move[i].vec());
  });
}

// Each fluid of a mixture in turn: what its particles find of another one counts as full by a share.
void draw_in_mixture(FluidPool& p, Real h, StepContext& c) {
  const SweepInput in = p.sweep_input();
  const auto phases = static_cast<std::uint32_t>(p.phases.size());
  const auto share = [&](std::uint32_t k, std::uint32_t i) { return p.pull_between(k, p.phase[i]) * p.share_of(i); };
  for (std::uint32_t k = 0; k < phases; ++k) {
    p.weigh(*c.jobs, [&](std::uint32_t i) { return share(k, i); });
    each_run(p, k, c, [&](std::uint32_t first, std::uint32_t last) {
      p.sweeps->colors_by(in, first, last, p.sum.data());
      for (std::uint32_t i = first; i < last; ++i)
        p.next_weight[i] = color_slope(p.color_energies[k], lack_of(p, i, p.sum[i]));
    });
  }
  const Real by = h * p.color_unit * p.volume / (p.support * p.support);
  for (std::uint32_t k = 0; k < phases; ++k) {
    const auto draw = [&](auto&& weight, auto&& own) {
      p.weigh(*c.jobs, weight);
      each_run(p, k, c, [&](std::uint32_t first, std::uint32_t last) {
        p.sweeps->draw_by(in, first, last, &p.move[0].x);
        for (std::uint32_t i = first; i < last; ++i)
          p.v[i].set(p.v[i].vec() + by / p.mass_of(i) * p.share_of(i) * own(i) * p.move[i].vec());
      });
    };
    draw([&](std::uint32_t i) { return share(k, i) * p.next_weight[i]; }, [](std::uint32_t) { return Real(1); });
    draw([&](std::uint32_t i) { return share(k, i); }, [&](std::uint32_t i) { return p.next_weight[i]; });
  }
  p.weigh(*c.jobs, [&](std::uint32_t i) { return p.next_weight[i]; });
}

// Of the boundary. Where the field counts it as full the fluid wets it with 90 degrees, that is sigma, else not at all.
class Wetting {
 public:
  Wetting(FluidPool& p, Boundary& boundary, Real h)
      : p_(p), boundary_(boundary), h_(h), colored_(tension_by_color(p)) {}

  void apply(StepContext& c) {
    weigh_blocks(p_.count, boundary_, c, [&](std::uint32_t i, Vec3* impulses) {
      for (const BoundaryContact& k : p_.contacts_of(i)) {
        const Vec3 impulse = h_ * force(i, k) * k.normal;
        p_.v[i].set(p_.v[i].vec() + impulse / p_.mass_of(i));
        if (impulses) impulses[boundary_.shapes[k.shape].body] -= impulse;
      }
    });
    for (const std::uint32_t at : p_.dynamic_contacts) {
      const BoundaryContact& k = p_.contacts[at];
      boundary_.body_of(k).push(p_.x[k.particle].vec(), -h_ * force(k.particle, k) * k.normal);
    }
  }

 private:
  // On a particle, away from the boundary, N.
  Real force(std::uint32_t i, const BoundaryContact& k) const {
    const FluidPool& own = p_.fluid_of(i);
    const Real s = clamp(k.distance(p_.x[i].vec()) / p_.support, 0, 1);
    if (!(own.desc.adhesion > 0) || s == 1) return 0;
    const Real excess = own.desc.adhesion - (colored_ ? own.desc.surface_tension : Real(0));
    const Real wetting = p_.is_mixture() ? p_.wettings[p_.phase[i]] : own.wetting;
    const Real pull = 4 * excess * wetting * s * (1 - s * s);
    const Real field = colored_ ? -p_.x[i].w * color_beyond(p_.dimension, s).slope : Real(0);
    return -own.volume / p_.support * (pull + field);
  }

  FluidPool& p_;
  Boundary& boundary_;
  Real h_;
  bool colored_;
};

}  // namespace

Real capillary_time(const FluidPool& p, Real length) {
  constexpr Real kTurn = Real(2 * 3.14159265358979323846);
  const Real sigma = std::max(p.desc.surface_tension, p.desc.adhesion);
  return sigma > 0 ? std::sqrt(p.lightest * p.desc.density * length * length * length / (kTurn * sigma)) : kInfinity;
}

void add_tension(FluidPool& p, Boundary& boundary, Real h, StepContext& c) {
  const bool tense = p.desc.surface_tension > 0, by_color = tension_by_color(p);
  if (by_color && p.is_mixture()) {
    draw_in_mixture(p, h, c);
  } else if (by_color) {
    find_lacks(p, c);
    draw_in(p, h, c);
  } else if (tense) {
    p.is_mixture() ? cohere_mixture(p, h, c) : cohere(p, h, c);
  }
  if (p.desc.adhesion > 0) Wetting(p, boundary, h).apply(c);
  if (by_color) p.clear_weights(*c.jobs);
}

}  // namespace feder
