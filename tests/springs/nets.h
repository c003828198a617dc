// Small nets for the tests of the springs system.
#pragma once
#include <string>
#include <vector>

#include "feder/net.h"
#include "feder/world.h"

namespace feder::test {

inline const SystemDescriptor* const kSpringsOnly[] = {&Springs::descriptor()};

inline WorldDesc weightless(double dt = 1.0 / 60, int substeps = 4) {
  WorldDesc d;
  d.gravity = Vec3(0, 0, 0);
  d.dt = dt;
  d.substeps = substeps;
  return d;
}

// `count` points in a row along x, `spacing` apart, neighbours joined.
inline NetDesc row_net(std::size_t count, Real spacing, Real mass, Real stiffness) {
  NetDesc d;
  for (std::size_t i = 0; i < count; ++i) {
    d.points.push_back(Vec3(static_cast<Real>(i) * spacing, 0, 0));
    d.masses.push_back(mass);
  }
  for (std::uint32_t i = 0; i + 1 < count; ++i) d.springs.push_back({i, i + 1, stiffness, 0, spacing});
  return d;
}

inline void step(World& w, int n) {
  for (int k = 0; k < n; ++k) w.step();
}

// Code of the first warning of the last step, or "".
inline std::string warning_of(World& w) {
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning) return w.events().warning_code(e);
  return "";
}

}  // namespace feder::test
