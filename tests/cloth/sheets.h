// Worlds with one cloth, for tests.
#pragma once
#include "cloth/solver.h"
#include "contact/surface_contact.h"
#include "feder/cloth.h"
#include "feder/world.h"
#include "support/catch.h"

namespace feder::test {

inline const SystemDescriptor* const kClothOnly[] = {&SurfaceContact::descriptor(), &Cloth::descriptor()};

inline ClothDesc sheet(std::uint32_t nx, std::uint32_t ny, Real width, Real height) {
  ClothDesc d;
  d.size[0] = width, d.size[1] = height;
  d.nx = nx, d.ny = ny;
  return d;
}

inline WorldDesc weightless() {  // and without air
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  return wd;
}

inline double component(const Vec3& v, int k) { return static_cast<double>(v[k]); }

// All velocities to zero: the quickest way to rest for what swings slowly.
inline void stop(Cloth& cloth, ObjectId id) {
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) cloth.set_velocity(id, i, Vec3(0, 0, 0));
}

// To rest: all motion is taken out whenever kinetic energy has passed a peak (where forces balance), until peaks stay
// below `speed` (m/s, mean) for half a second of the world.
inline int relax(World& w, ObjectId id, double seconds, double speed = 2e-4) {
  Cloth& cloth = w.need<Cloth>();
  double mass = 0, last = 0, quiet = 0;
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) mass += static_cast<double>(cloth.point_mass(id, i));
  const int steps = static_cast<int>(seconds / w.desc().dt);
  for (int k = 0; k < steps; ++k) {
    w.step();
    const double now = w.energy().kinetic;
    quiet = now > 0.5 * mass * speed * speed ? 0 : quiet + w.desc().dt;
    if (quiet > 0.5) return k;
    if (now < last) stop(cloth, id);
    last = now < last ? 0 : now;
  }
  return steps;
}

}  // namespace feder::test
