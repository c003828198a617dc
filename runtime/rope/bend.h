// Bends of a chain: the angle between two directions, and the elastic energy angle^2/2 by the change of direction.
#pragma once
#include <cmath>

#include "base/double3.h"
#include "base/trig.h"

namespace feder {

inline Double3 direction_of(const Double3& e, double length) {
  return length > 0 ? (1 / length) * e : Double3{0, 1, 0};
}

// A bend from direction a to b, both unit: what its energy angle^2/2 pulls along b - a is `factor`. Close to a fold,
// where that grows without bounds, factor is held and `angle` is what has the same energy.
struct Bend {
  Double3 change;  // b - a
  double factor;   // angle/sin(angle)
  double angle;
};

inline Bend bend_between(const Double3& a, const Double3& b) {
  constexpr double kMostFactor = 20, kMostAngle = 2.991456433400576;  // factor of that angle
  constexpr double kSquaredChange = 3.97750142454327;                 // and |b - a|^2
  Bend k;
  k.change = b - a;
  const double sine = length(cross(a, b)), cosine = dot(a, b);
  k.angle = sine > 1e-6 || cosine < 0 ? arc_tangent2(sine, cosine) : sine;
  k.factor = sine > 1e-6 ? k.angle / sine : 1;
  if (k.angle > kMostAngle) {
    k.factor = kMostFactor;
    const double more = dot(k.change, k.change) - kSquaredChange;
    k.angle = std::sqrt(std::fmax(kMostAngle * kMostAngle + kMostFactor * more, kMostAngle * kMostAngle));
  }
  return k;
}

}  // namespace feder
