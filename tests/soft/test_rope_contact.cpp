// Soft bodies and ropes.
#include "feder/rope.h"
#include "soft_contact.h"

namespace feder::test {
namespace {

RopeDesc rope_between(const Vec3& a, const Vec3& b, int segments) {
  RopeDesc d;
  for (int i = 0; i <= segments; ++i)
    d.points.push_back(a + static_cast<Real>(i) / static_cast<Real>(segments) * Vec3(b - a));
  d.radius = Real(0.015);
  return d;
}

// Segments, as triangles that have no area: their edges count.
void add_segments(Soup& s, const Rope& rope) {
  for (std::size_t n = 0; n < rope.rope_count(); ++n) {
    std::vector<std::uint32_t> triangles;
    const auto count = static_cast<std::uint32_t>(rope.info(n).points.size());
    for (std::uint32_t i = 0; i + 1 < count; ++i) triangles.insert(triangles.end(), {i, i + 1, i + 1});
    add_skin(s, rope.info(n).points, triangles);
  }
}

}  // namespace

TEST_CASE("a soft block on two ropes lies still and is cut nowhere", "[soft]") {
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  for (const double z : {-0.08, 0.08}) {
    const Real at = static_cast<Real>(z);
    RopeDesc r = rope_between(vec3(Real(-0.5), 1, at), vec3(Real(0.5), 1, at), 20);
    r.pins = {0, 20};
    rope.add_rope(r);
  }
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.3), Real(0.1), Real(0.3)), 6);
  d.density = 300;
  d.pose.position = vec3(Real(0.02), Real(1.1), 0);
  const ObjectId id = soft.add_soft(d);
  run_without_crossing(w, 6, [&](Soup& s) { add_segments(s, rope); });
  CHECK(number(center_of(soft, id)[1]) > 0.7);
  CHECK(speed_of(soft, id) < 0.02);
}

TEST_CASE("a soft block that flies into a rope in free space takes it along and keeps momentum", "[soft]") {
  World w(free_space(), catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId line = rope.add_rope(rope_between(vec3(Real(-0.5), 0, 0), vec3(Real(0.5), 0, Real(0.05)), 20));
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 4);
  d.pose.position = vec3(Real(0.03), Real(0.3), Real(0.02));
  d.velocity = Vec3(0, -3, 0);
  const ObjectId id = soft.add_soft(d);
  const Momentum before = w.momentum();
  run_without_crossing(w, 0.5, [&](Soup& s) { add_segments(s, rope); });
  check_momentum(before, w.momentum(), 3 * mass_of(soft, id));
  CHECK(number(rope.velocity(line, 10)[1]) < -1);
}

}  // namespace feder::test
