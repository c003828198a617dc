// Angular momentum that the forces inside a soft thing gave it: they act where a solver substep ends, which is a torque
// about where it began. It is taken out once per substep, as a rotation of the whole about its centre of mass.
#pragma once
#include <cstdint>

#include "feder/types.h"

namespace feder {

// Adds to the velocities of n points, add(i, change), what turns them by -gained, kg m^2/s. mass(i), kg; place(i), m,
// from any point near by; total: the sum of the masses. `round`: of the trace, by which moments of inertia count as
// larger, for what has none about an axis. Nothing where the inertia has no inverse.
template <class Mass, class Place, class Add>
void take_out_spin(const Vec3& gained, std::uint32_t n, Real total, Real round, Mass&& mass, Place&& place, Add&& add) {
  Vec3 middle = Vec3::Zero();
  for (std::uint32_t i = 0; i < n; ++i) middle += mass(i) * place(i);
  middle /= total;
  Mat3 inertia = Mat3::Zero();
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3 r = place(i) - middle;
    inertia -= mass(i) * (r * r.transpose());
  }
  inertia.diagonal().array() -= (1 + round) * inertia.trace();
  const Vec3 angular_velocity = inverse(inertia) * gained;  // rad/s
  if (!is_finite(angular_velocity)) return;                 // without extent, or gone bad
  for (std::uint32_t i = 0; i < n; ++i) add(i, Vec3(-cross(angular_velocity, Vec3(place(i) - middle))));
}

}  // namespace feder
