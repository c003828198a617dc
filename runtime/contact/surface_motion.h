// Motion of points and bodies of surfaces within a solver substep of h seconds.
#pragma once
#include "state/surface.h"

namespace feder {

// Displacement of a point in the solver substep, as its velocity will be read: from `before`, and, where that is the
// position at the substep's end (w 1), with that of its velocity.
inline Vec3 change_of(const Surfaces& s, std::uint32_t point, Real h) {
  Vec3 change = s.delta_position[point].vec() - s.before[point].vec();
  if (s.before[point].w != 0) change += h * s.velocity[point].vec();
  return change;
}

// Velocity of a point of a solver body, m/s.
inline Vec3 velocity_at(const SolverBody& body, const Vec3& arm) {
  return body.velocity + cross(body.angular_velocity, arm);
}

}  // namespace feder
