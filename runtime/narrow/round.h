// The contact of two balls, and of the nearest points of two rounded cores.
#pragma once
#include "narrow/manifold.h"

namespace feder {

// Fills `point` and the normal from a to b (`fallback` when the centres coincide); false beyond the margin.
inline bool round_point(const Vec3& center_a, Real radius_a, const Vec3& center_b, Real radius_b, Real margin,
                        const Vec3& fallback, Vec3& normal, ManifoldPoint& point) {
  const Vec3 d = center_b - center_a;
  const Real limit = radius_a + radius_b + margin, squared = dot(d, d);
  if (squared > limit * limit) return false;
  const Real separation = std::sqrt(squared) - radius_a - radius_b;
  normal = normalized_or(d, fallback);
  point.position = center_a + normal * (radius_a + separation / 2);
  point.separation = separation;
  return true;
}

}  // namespace feder
