// Flow on an area: with F the force on one square metre held across the flow, e its direction, n the area's normal and
// c = e.n, the pressure on an inclined plate is |F| A c n, two-sided; its part along the flow, c^2 e, is scaled by
// `drag`, the part across it, c (n - c e), by `lift`. What streams along the area rubs at kSkin of that.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "feder/params.h"
#include "feder/types.h"

namespace feder {

constexpr Real kSkin = Real(0.02);
// Of the mass of a triangle's lightest corner, that still air may stop in a step: each corner gets a third of that from
// each of its triangles, of which there are eight at most in a sheet.
constexpr Real kMaxMassShare = Real(0.35);

// kg/m^3: what a world says of its air.
inline constexpr OptionRow kAirDensity{"air_density", "kg/m3", {0, 1e6}};
inline Real still_air_density(const Params& world) { return world.real(kAirDensity, 1.2); }

struct AreaShares {
  Real drag = 1, lift = 1;
};

// On the triangle with twice its area times its normal, N.
inline Vec3 area_force(const Vec3& full, const Vec3& twice, const AreaShares& share) {
  const Real area = Real(0.5) * length(twice), size = length(full);
  if (!(area > 0) || !(size > 0)) return Vec3(0, 0, 0);
  const Vec3 n = twice / (2 * area), e = full / size;
  const Real along = dot(e, n);
  return (size * area) * (share.drag * (along * along + kSkin) * e + share.lift * along * (n - along * e));
}

// Of still air on a triangle with velocity u: the wind force with velocity 0, N; area_force() of -density |u| u / 2
// with e and n multiplied out. `most`, kg/s: mass that it may stop over the time in which it acts; drag of light cloth
// at high speed, or of one that is stretched to many times its area, would turn it round within a step otherwise.
// Cloth has this eight wide (cloth/kernel.h).
inline Vec3 still_air(const Vec3& u, const Vec3& twice, Real density, Real most, const AreaShares& share) {
  const Real speed2 = dot(u, u), area2 = dot(twice, twice), through = dot(u, twice), both = speed2 * area2;
  using Limits = std::numeric_limits<Real>;
  if (!(both >= Limits::min() && both <= Limits::max())) return Vec3(0, 0, 0);  // beyond what numbers can tell
  const Real asked = Real(0.25) * density * std::sqrt(both), rate = std::min(asked, most);
  const Real square = through * through / both;  // of e.n
  const Real along = share.drag * (square + kSkin) - share.lift * square;
  return -rate * (along * u + (share.lift * through / area2) * twice);
}

// Of still air on one square metre across the flow, N: that of the wind with velocity 0, `most` kg/s at most.
inline Vec3 still_air_on_area(const Vec3& u, Real density, Real most) {
  return -std::min(Real(0.5) * density * length(u), most) * u;
}

// On a cylinder from one end of `along` to the other: the part of the flow across it alone makes the drag (Hoerner
// 1965, 3-11), so that with c the cosine between flow and cylinder it is |F| A sqrt(1 - c^2) times the part of e across
// it; what streams along it rubs at kSkin.
inline Vec3 line_force(const Vec3& full, const Vec3& along, Real width, Real drag) {
  const Real size = length(full), long_side = length(along);
  if (!(size > 0) || !(long_side > 0)) return Vec3(0, 0, 0);
  const Vec3 t = along / long_side, e = full / size;
  const Real c = dot(e, t);
  const Vec3 across = e - c * t;
  return (size * long_side * width * drag) * (length(across) * across + kSkin * std::abs(c) * c * t);
}

}  // namespace feder
