// What meets soft bodies, for tests: edges that pass through faces, momentum of a meeting in free space, rest.
#pragma once
#include "cloth/crossings.h"
#include "soft_bodies.h"

namespace feder::test {

// Free space: no weight, no air.
inline WorldDesc free_space() {
  WorldDesc desc = weightless();
  desc.options.set("air_density", 0.0);
  return desc;
}

inline void add_skin(Soup& s, const std::span<const Vec3> points, const std::span<const std::uint32_t> triangles) {
  const auto first = static_cast<std::uint32_t>(s.points.size());
  for (const Vec3& p : points) s.points.push_back({number(p[0]), number(p[1]), number(p[2])});
  for (const std::uint32_t v : triangles) s.triangles.push_back(first + v);
}

inline void add_skins(Soup& s, const Soft& soft) {
  for (std::size_t n = 0; n < soft.soft_count(); ++n) add_skin(s, soft.info(n).points, soft.info(n).skin);
}

// Steps for a time in which nothing crosses a skin; `fill` adds what may.
template <class F>
void run_without_crossing(World& w, double seconds, F&& fill) {
  const Soft& soft = w.need<Soft>();
  std::size_t crossings = 0;
  int first = -1;
  for (int k = 0; k < seconds * 60; ++k) {
    w.step();
    Soup s;
    add_skins(s, soft);
    fill(s);
    const std::size_t now = count_crossings(s);
    if (now && first < 0) first = k;
    crossings += now;
  }
  CAPTURE(first);
  CHECK(crossings == 0);
  CHECK(w.is_finite());
}

// As a share of `scale`; angular momentum of `scale` times 1 m, within `angular`: contact pushes where a solver substep
// ends, which is a torque of h times impulse and speed about where it began.
inline void check_linear(const Momentum& before, const Momentum& after, double scale) {
  for (int k = 0; k < 3; ++k) CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-5 * scale);
}
inline void check_momentum(const Momentum& before, const Momentum& after, double scale, double angular = 1e-3) {
  check_linear(before, after, scale);
  for (int k = 0; k < 3; ++k) CHECK(std::fabs(after.angular[k] - before.angular[k]) < angular * scale);
}

inline double mass_of(const Soft& soft, ObjectId id) {
  double sum = 0;
  for (std::size_t i = 0; i < soft.point_count(id); ++i) sum += number(soft.point_mass(id, i));
  return sum;
}

inline Vec3 center_of(const Soft& soft, ObjectId id) {
  double sum[4] = {};
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const double m = number(soft.point_mass(id, i));
    for (int k = 0; k < 3; ++k) sum[k] += m * number(soft.point(id, i)[k]);
    sum[3] += m;
  }
  return vec3(static_cast<Real>(sum[0] / sum[3]), static_cast<Real>(sum[1] / sum[3]),
              static_cast<Real>(sum[2] / sum[3]));
}

// Of its points, root mean square, m/s.
inline double speed_of(const Soft& soft, ObjectId id) {
  double sum = 0;
  for (std::size_t i = 0; i < soft.point_count(id); ++i)
    sum += number(soft.point_mass(id, i)) * number(dot(soft.velocity(id, i), soft.velocity(id, i)));
  return std::sqrt(sum / mass_of(soft, id));
}

inline ObjectId add_ground(World& w) {
  BodyDesc ground;
  ground.type = BodyType::fixed;
  ground.shape = make_plane(Vec3(0, 1, 0), 0);
  return w.need<Rigid>().add_body(ground);
}

}  // namespace feder::test
