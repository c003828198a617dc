// Worlds with ropes, for tests.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "feder/rigid.h"
#include "feder/rope.h"
#include "feder/systems.h"
#include "feder/world.h"
#include "support/catch.h"

namespace feder::test {

inline double number(Real x) { return static_cast<double>(x); }

inline WorldDesc vacuum(const Vec3& gravity = Vec3(0, Real(-9.81), 0)) {
  WorldDesc d;
  d.gravity = gravity;
  d.options.set("air_density", 0.0);
  return d;
}

// `segments` equal ones from a to b.
inline RopeDesc straight_rope(const Vec3& a, const Vec3& b, int segments) {
  RopeDesc d;
  for (int i = 0; i <= segments; ++i) {
    const Real share = static_cast<Real>(i) / static_cast<Real>(segments);
    d.points.push_back(a + share * (b - a));
  }
  return d;
}

inline void still(Rope& rope, ObjectId id) {
  for (std::size_t i = 0; i < rope.point_count(id); ++i) rope.set_velocity(id, i, Vec3(0, 0, 0));
}

// To rest: motion is taken out whenever kinetic energy has passed a peak, until peaks stay below `speed`.
inline void settle(World& w, ObjectId id, double seconds, double speed = 1e-4) {
  Rope& rope = w.need<Rope>();
  double mass = 0, last = 0, quiet = 0;
  for (std::size_t i = 0; i < rope.point_count(id); ++i) mass += number(rope.point_mass(id, i));
  for (int k = 0; k < seconds * 60 && quiet < 0.5; ++k) {
    w.step();
    const double now = w.energy().kinetic;
    quiet = now > 0.5 * mass * speed * speed ? 0 : quiet + 1.0 / 60;
    if (now < last) still(rope, id);
    last = now < last ? 0 : now;
  }
}

}  // namespace feder::test
