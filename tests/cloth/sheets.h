// Worlds with one cloth, for tests.
#pragma once
#include "cloth/cloth.h"
#include "cloth/solver.h"
#include "support/catch.h"
#include "world/world.h"

namespace feder::test {

inline const SystemDescriptor* const kClothOnly[] = {&Cloth::descriptor()};

inline ClothDesc sheet(std::uint32_t nx, std::uint32_t ny, Real width, Real height) {
  ClothDesc d;
  d.size[0] = width, d.size[1] = height;
  d.nx = nx, d.ny = ny;
  return d;
}

inline double component(const Vec3& v, int k) { return static_cast<double>(v[k]); }

// Steps until the kinetic energy per mass stays small; the world's damping has to see to that.
inline int settle(World& w, double least_seconds, double most_seconds, double speed) {
  int steps = 0;
  const double dt = w.desc().dt;
  double mass = 0;
  const ClothVertices& v = w.need<Cloth>().vertices();
  for (std::uint32_t i = 0; i < v.size(); ++i) mass += static_cast<double>(v.mass[i]);
  while (steps * dt < most_seconds) {
    w.step();
    ++steps;
    if (steps * dt > least_seconds && w.energy().kinetic < 0.5 * mass * speed * speed) break;
  }
  return steps;
}

// All velocities to zero: the quickest way to rest for what swings slowly.
inline void stop(Cloth& cloth, ObjectId id) {
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) cloth.set_velocity(id, i, Vec3(0, 0, 0));
}

// To rest: motion is taken out every few steps, and in each of the last second.
inline void relax(World& w, ObjectId id, double seconds) {
  Cloth& cloth = w.need<Cloth>();
  const int steps = static_cast<int>(seconds / w.desc().dt);
  for (int k = 0; k < steps; ++k) {
    w.step();
    if (k % 6 == 0 || k > steps - 60) stop(cloth, id);
  }
}

}  // namespace feder::test
