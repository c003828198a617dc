// The angle of a hinge and its gradient (Bridson 2003; Tamstorf and Grinspun 2013), one hinge at a time, in the numbers
// of V (Vec3 or Double3): for solvers that hold hinges in a potential. kernel.h has the same eight wide. Private to the
// module.
#pragma once
#include <algorithm>

#include "base/double3.h"
#include "base/trig.h"
#include "cloth/mesh.h"

namespace feder {

// Squares below which lengths no longer count as divisors: a share of those at rest. A narrower triangle is pushed as
// if it were that wide, since the gradient has no bound where an area vanishes.
struct HingeFloor {
  Real edge = 0, first = 0, second = 0;  // m^2; m^4, of twice the areas
};

inline HingeFloor hinge_floor(const ClothHinge& h, const Vec3* rest) {
  constexpr Real kNarrow = Real(0.05);
  const Vec3 e = rest[h.v[1]] - rest[h.v[0]], n1 = cross(e, rest[h.v[2]] - rest[h.v[0]]),
             n2 = cross(rest[h.v[3]] - rest[h.v[0]], e);
  const Real k = kNarrow * kNarrow;
  return {k * dot(e, e), k * dot(n1, n1), k * dot(n2, n2)};
}

template <class V>
struct Dihedral {
  V gradient[4];                         // of the angle, rad/m
  decltype(dot(V(), V())) sine, cosine;  // of the angle, times both areas and more
};

// e, a, b: v[1], v[2], v[3] minus v[0].
template <class V>
Dihedral<V> dihedral(const V& e, const V& a, const V& b, const HingeFloor& floor) {
  using T = decltype(dot(e, e));
  Dihedral<V> d;
  const V n1 = cross(e, a), n2 = cross(b, e);
  const T e2 = dot(e, e), size = std::sqrt(e2);
  d.sine = size > 0 ? dot(cross(n1, n2), e) / size : T(0);
  d.cosine = dot(n1, n2);
  // v[2] or v[3] moving along its triangle's normal closes the angle at 1/height
  const T long2 = std::max(e2, T(floor.edge)), s1 = std::max(dot(n1, n1), T(floor.first)),
          s2 = std::max(dot(n2, n2), T(floor.second));
  d.gradient[2] = (-size / s1) * n1;
  d.gradient[3] = (-size / s2) * n2;
  const T from_a = -dot(a, e) / long2, from_b = -dot(b, e) / long2;
  d.gradient[1] = from_a * d.gradient[2] + from_b * d.gradient[3];
  const V sum = d.gradient[1] + d.gradient[2] + d.gradient[3];
  d.gradient[0] = T(-1) * sum;
  return d;
}

// An angle less whole turns, in [-pi, pi].
inline double within_turn(double angle) {
  constexpr double kTurn = 6.283185307179586;
  return angle > kTurn / 2 ? angle - kTurn : angle < -kTurn / 2 ? angle + kTurn : angle;
}

}  // namespace feder
