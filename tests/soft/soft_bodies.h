// Worlds with soft bodies, for tests.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "feder/rigid.h"
#include "feder/soft.h"
#include "feder/systems.h"
#include "feder/world.h"
#include "soft/solver.h"
#include "support/catch.h"

namespace feder::test {

inline double number(Real x) { return static_cast<double>(x); }

inline std::string any_soft_solver() {
  return soft_solvers()[static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(soft_solvers().size()))))].name;
}
// Those that solve backward Euler, which damps like a material of tau = h.
inline bool is_backward_euler(const std::string& solver) { return solver == "vbd" || solver == "implicit"; }
// Springs and volumes, whose material is only near to the one asked for; without Poisson's ratios below 1/4.
inline bool is_springs(const std::string& solver) { return solver == "mass_spring"; }

inline SoftDesc soft_box(const Vec3& size, std::uint32_t resolution) {
  SoftDesc d;
  d.shape = make_box(size[0], size[1], size[2]);
  d.resolution = resolution;
  return d;
}

inline WorldDesc weightless() {
  WorldDesc desc;
  desc.gravity = Vec3(0, 0, 0);
  return desc;
}

// Steps for a time in which its own damping brings it to rest, up to a mean speed that is left.
inline void settle(World& w, double seconds, double speed) {
  double mass = 0;
  Soft& soft = w.need<Soft>();
  for (std::size_t n = 0; n < soft.soft_count(); ++n) {
    const ObjectId id = soft.info(n).object;
    for (std::size_t i = 0; i < soft.point_count(id); ++i) mass += number(soft.point_mass(id, i));
  }
  for (int k = 0; k < seconds * 60; ++k) w.step();
  CHECK(w.energy().kinetic < 0.5 * mass * speed * speed);
}

// Forces of a stress on the skin as it lies, Pa: pressure[axis] pulls along the axis at the faces that look along it.
inline void pull_faces(Soft& soft, ObjectId id, const Vec3& pressure) {
  const Soft::Info info = soft.info(id);
  std::vector<Vec3> force(info.points.size(), Vec3::Zero());
  for (std::size_t t = 0; t < info.skin.size(); t += 3) {
    const Vec3 a = soft.point(id, info.skin[t]), b = soft.point(id, info.skin[t + 1]),
               c = soft.point(id, info.skin[t + 2]);
    const Vec3 area = Real(0.5) * cross(Vec3(b - a), Vec3(c - a));
    for (std::size_t k = 0; k < 3; ++k) force[info.skin[t + k]] += pressure.cwiseProduct(area) / 3;
  }
  for (std::size_t i = 0; i < force.size(); ++i) soft.set_script_force(id, i, force[i]);
}

// Largest extent along an axis, m, over the points whose rest position lies at both ends of it: their mean distance.
inline double side(const Soft& soft, ObjectId id, int axis) {
  double lo = 1e9, hi = -1e9, sum[2] = {0, 0}, count[2] = {0, 0};
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const double x = number(soft.rest_point(id, i)[axis]);
    lo = std::min(lo, x), hi = std::max(hi, x);
  }
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const double x = number(soft.rest_point(id, i)[axis]);
    const int end = x > hi - 1e-6 ? 1 : x < lo + 1e-6 ? 0 : -1;
    if (end < 0) continue;
    sum[end] += number(soft.point(id, i)[axis]), count[end] += 1;
  }
  return sum[1] / count[1] - sum[0] / count[0];
}

inline std::size_t count_warnings(World& w, const char* code) {
  std::size_t n = 0;
  for (const Event& e : w.events().list()) n += e.kind == EventKind::warning && w.events().warning_code(e) == code;
  return n;
}

}  // namespace feder::test
