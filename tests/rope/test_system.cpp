// Ropes as a system: bad input, quarantine, snapshots, threads, sleep, contact with bodies, what an empty world has of
// them.
#include <limits>

#include "ropes.h"
#include "state/bodies.h"

namespace feder::test {
namespace {

// A rope that falls over a box onto the ground.
ObjectId add_scene(World& w) {
  BodyDesc ground;
  ground.type = BodyType::fixed;
  ground.shape = make_plane(Vec3(0, 1, 0), 0);
  BodyDesc box;
  box.shape = make_box(Real(0.4), Real(0.4), Real(0.4));
  box.position = Vec3(0, Real(0.2), 0);
  w.need<Rigid>().add_body(ground);
  w.need<Rigid>().add_body(box);
  RopeDesc d = straight_rope(vec3(Real(-0.7), Real(0.6), 0), vec3(Real(0.9), Real(0.6), Real(0.05)), 30);
  d.radius = Real(0.02);
  return w.need<Rope>().add_rope(d);
}

}  // namespace

TEST_CASE("ropes that cannot be are errors that say what was expected", "[rope]") {
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  const RopeDesc good = straight_rope(Vec3(0, 0, 0), Vec3(1, 0, 0), 4);
  const auto refused = [&](auto&& spoil) {
    RopeDesc d = good;
    spoil(d);
    CHECK_THROWS_AS(rope.add_rope(d), SceneError);
  };
  refused([](RopeDesc& d) { d.points.resize(1); });
  refused([](RopeDesc& d) { d.points[2] = d.points[1]; });
  refused([](RopeDesc& d) { d.points[2][0] = kInfinity; });
  refused([](RopeDesc& d) { d.radius = 0; });
  refused([](RopeDesc& d) { d.density = -1; });
  refused([](RopeDesc& d) { d.stretch = NAN; });
  refused([](RopeDesc& d) { d.bend = -1; });
  refused([](RopeDesc& d) { d.drag = NAN; });
  refused([](RopeDesc& d) { d.pins = {5}; });
  CHECK(rope.rope_count() == 0);
  CHECK(w.objects().count(kRopeKind) == 0);
  const ObjectId id = rope.add_rope(good);
  CHECK_THROWS_AS(rope.point(id, 5), SceneError);
  CHECK_THROWS_AS(rope.strain(id, 4), SceneError);
  CHECK_THROWS_AS(rope.set_point(id, 0, vec3(NAN, 0, 0)), SceneError);
}

TEST_CASE("a rope over a box goes on from a snapshot and does not depend on threads", "[rope][threads]") {
  std::uint64_t hashes[3];
  for (int k = 0; k < 3; ++k) {
    WorldDesc desc;
    desc.threads = k == 1 ? 4 : 1;
    World w(desc, catalog());
    add_scene(w);
    for (int i = 0; i < 30; ++i) w.step();
    if (k == 2) {
      const std::string image = w.snapshot();
      for (int i = 0; i < 10; ++i) w.step();
      w.restore(image);
    }
    for (int i = 0; i < 30; ++i) w.step();
    hashes[k] = w.hash();
  }
  CHECK(hashes[0] == hashes[1]);
  CHECK(hashes[0] == hashes[2]);
}

TEST_CASE("a rope comes to rest on a box and the ground and sleeps", "[rope]") {
  World w(WorldDesc{}, catalog());
  const ObjectId id = add_scene(w);
  Rope& rope = w.need<Rope>();
  int begun = 0, slept = 0;
  for (int i = 0; i < 60 * 12 && !rope.asleep(id); ++i) {
    w.step();
    for (const Event& e : w.events().list()) {
      begun += e.kind == EventKind::contact_begin && (e.a == id || e.b == id);
      slept += e.kind == EventKind::sleep && e.a == id;
    }
  }
  CHECK(begun >= 2);
  CHECK(slept == 1);
  CHECK(rope.asleep(id));
  CHECK(w.is_finite());
  Real lowest = 1, highest = 0;
  for (std::size_t i = 0; i <= 30; ++i) {
    lowest = std::min(lowest, rope.point(id, i)[1]);
    highest = std::max(highest, rope.point(id, i)[1]);
  }
  CHECK(std::fabs(number(lowest) - 0.02) < 0.002);   // on the ground
  CHECK(std::fabs(number(highest) - 0.42) < 0.004);  // and on the box
  CHECK(number(rope.max_strain(id)) < 0.01);
  // pulled, it wakes
  rope.set_script_force(id, 30, Vec3(5, 0, 0));
  w.step();
  CHECK_FALSE(rope.asleep(id));
}

TEST_CASE("a ball thrown against a hung rope hands on its momentum", "[rope]") {
  World w(vacuum(Vec3(0, 0, 0)), catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(straight_rope(vec3(0, Real(-0.5), 0), vec3(0, Real(0.5), 0), 20));
  BodyDesc ball;
  ball.shape = make_sphere(Real(0.05));
  ball.position = vec3(Real(-0.3), Real(0.01), 0);
  ball.velocity = Vec3(8, 0, 0);
  const ObjectId body = w.need<Rigid>().add_body(ball);
  const Momentum before = w.momentum();
  for (int i = 0; i < 30; ++i) w.step();
  const Momentum after = w.momentum();
  for (int k = 0; k < 3; ++k) {
    CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-5 * before.linear[0]);
    CHECK(std::fabs(after.angular[k] - before.angular[k]) < 1e-3 * before.linear[0]);
  }
  // it has not passed: the middle of the rope is before it
  CHECK(w.need<Rigid>().bodies().position[w.need<Rigid>().index(body)][0] < rope.point(id, 10)[0]);
}

TEST_CASE("a rope in quarantine stays at rest, whatever scripts do to it", "[rope]") {
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(straight_rope(Vec3(0, 3, 0), Vec3(1, 3, 0), 4));
  rope.set_velocity(id, 2, Vec3(std::numeric_limits<Real>::max(), 0, 0));
  w.step();
  REQUIRE(rope.quarantined(id));
  rope.set_velocity(id, 1, Vec3(1, 0, 0));
  rope.apply_impulse(id, 3, Vec3(0, 1, 0));
  for (std::size_t i = 0; i < 5; ++i) CHECK(rope.velocity(id, i).isZero(0));
  w.step();
  CHECK(rope.point(id, 2) == Vec3(Real(0.5), 3, 0));
}

TEST_CASE("what has no rope has no pass of ropes", "[rope]") {
  World w(WorldDesc{}, catalog());
  BodyDesc box;
  box.shape = make_box(1, 1, 1);
  w.need<Rigid>().add_body(box);
  w.step();
  CHECK(w.find<Rope>() == nullptr);
  const ObjectId id = w.need<Rope>().add_rope(straight_rope(Vec3(0, 3, 0), Vec3(1, 3, 0), 4));
  w.step();
  w.need<Rope>().destroy_rope(id, "here");
  w.step();
  CHECK(w.need<Rope>().count() == 0);
}

}  // namespace feder::test
