// The contact of two balls, and of the nearest points of two rounded cores.
#pragma once
#include "narrow/manifold.h"

namespace feder {

// One point, and the normal from a to b (`fallback` when the centres coincide). Returns the count of points, 0 beyond
// the margin.
inline int round_contact(const Vec3& center_a, Real radius_a, const Vec3& center_b, Real radius_b, Real margin,
                         const Vec3& fallback, Manifold& out) {
  const Vec3 d = center_b - center_a;
  const Real limit = radius_a + radius_b + margin, squared = dot(d, d);
  if (squared > limit * limit) return out.count = 0;
  const Real separation = std::sqrt(squared) - radius_a - radius_b;
  out.normal = normalized_or(d, fallback);
  out.points[0] = {center_a + out.normal * (radius_a + separation / 2), separation, 0};
  return out.count = 1;
}

}  // namespace feder
