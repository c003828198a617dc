// Boundary terms of a particle at signed distance s from a solid (in units of the support), exact for planes, and for
// other solids by their nearest plane.
// Density: not the integral of the kernel over the solid but a steeper function of the distance, a exp(-b s): it has
// the value that the missing half of a lattice has for the first layer at rest, half a spacing from the wall, and
// twice its slope. The force on a particle then follows from an energy alone (mirrored pressure, as of Akinci et al.
// 2012, needs a factor 2 that follows from none, and drives currents along upright boundaries), and is in balance where
// the layer belongs: particles do not clump at boundaries. Inside the solid it goes on in a straight line. Colour and
// friction: true integrals over the half space (Bender et al., "Volume Maps", MIG 2019; Morris 1997). Weak spot: in
// corners of two solids both count in full, at convex edges too: particles keep about a tenth of a spacing more
// distance there. Thin plates weigh like thick ones, on purpose.
#pragma once
#include "sph/kernel.h"

namespace feder {

struct BoundaryTerms {
  WideReal value = 0;   // added to density over density at rest
  WideReal slope = 0;   // -d value / d s
  WideReal share = 0;   // of the kernel that lies in the solid
  WideReal colour = 0;  // -d share / d s
  // no-slip friction with the velocity continued oddly through the boundary (Morris 1997): a = -nu v friction / (s
  // support^2)
  WideReal friction = 0;
};

class BoundaryTable {
 public:
  static constexpr int kCells = 256;
  // For a kernel with a support of `support` spacings.
  BoundaryTable(const Kernel& kernel, int dimension, double support);
  // s in [-1, 1]; beyond 1 nothing, below -1 as at -1.
  BoundaryTerms at(WideReal s) const {
    constexpr int half = kCells / 2;
    const WideReal t = (s + 1) * half;
    const int i = !(t > 0) ? 0 : t >= kCells - 1 ? kCells - 1 : static_cast<int>(t);  // NaN: the first
    const WideReal f = t <= 0 ? 0 : t >= kCells ? 1 : t - static_cast<WideReal>(i);
    const BoundaryTerms &a = samples_[i], &b = samples_[i + 1];
    return {a.value + f * (b.value - a.value), a.slope + f * (b.slope - a.slope), a.share + f * (b.share - a.share),
            a.colour + f * (b.colour - a.colour), a.friction + f * (b.friction - a.friction)};
  }

  // The share of the kernel beyond a plane where its slope by the distance is `colour`; at most that of the half space.
  WideReal air(WideReal colour) const {
    const WideReal t = colour / samples_[kCells / 2].colour * kAirCells;
    if (!(t > 0)) return 0;
    const int i = t < kAirCells ? static_cast<int>(t) : kAirCells - 1;
    const WideReal f = t < kAirCells ? t - static_cast<WideReal>(i) : 1;
    return air_[i] + f * (air_[i + 1] - air_[i]);
  }

 private:
  static constexpr int kAirCells = 128;
  WideReal air_[kAirCells + 1];
  BoundaryTerms samples_[kCells + 1];
};

// Sums of a particle on a lattice of spacing 1 with the kernel's support in spacings: the kernel's sum over the whole
// lattice (itself included), and over what lies beyond the particle's layer on one side, with the slope of that sum
// by the distance to that side; and the sum of the squared gradients of the whole.
// `viscosity`: viscous sum over pairs in a shear whose rows slide over each other, over the true value.
struct LatticeSums {
  double whole = 0, missing = 0, missing_slope = 0, squares = 0, viscosity = 0;
};
LatticeSums lattice_sums(const Kernel& kernel, int dimension, double support);

// Moment of the cohesion of the sums over neighbours (sweeps.h): the integral of u^power cohesion(u) over [0, 1].
double cohesion_moment(int power);

// Of the colour field, whose kernel is 1 - u^2 with a support in spacings. Lattice sums: over a whole lattice with the
// particle itself; and over the layers below a flat face, half a spacing below it the first: of the cubes of what each
// lacks to the whole, over the whole; and of (1 - s^2)^2, s their depth in supports.
struct ColorSums {
  double whole = 0, lack = 0, depth = 0;
};
ColorSums color_sums(int dimension, double support);
// Share of that kernel beyond a plane at s supports, 0 to 1, and its derivative by s.
struct ColorShare {
  WideReal value, slope;
};
ColorShare color_beyond(int dimension, WideReal s);

}  // namespace feder
