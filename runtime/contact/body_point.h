// Velocities of the points of solver bodies at which rows of surfaces act.
#pragma once
#include "state/solver_bodies.h"

namespace feder {

// `arm`: from the centre of mass, m.
inline Vec3 velocity_at(const SolverBody& body, const Vec3& arm) {
  return body.velocity + cross(body.angular_velocity, arm);
}

}  // namespace feder
