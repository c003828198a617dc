// Points of soft things held to each other and to bodies: both sides pay, gaps are reported, snapshots hold them.
#include "feder/cloth.h"
#include "feder/net.h"
#include "ropes.h"
#include "state/bodies.h"

namespace feder::test {
namespace {

// Warnings of this step with such words.
int warnings(World& w, const char* words) {
  int count = 0;
  for (const Event& e : w.events().list())
    if (e.kind == EventKind::warning) count += w.events().warning_message(e).find(words) != std::string::npos;
  return count;
}

NetDesc net_between(const Vec3& a, const Vec3& b) {
  NetDesc d;
  d.points = {a, b}, d.masses = {Real(0.05), Real(0.05)}, d.radius = Real(0.01);
  d.springs.push_back({.i = 0, .j = 1, .stiffness = 200});
  return d;
}

}  // namespace

TEST_CASE("a rope, a cloth and a net that are held to each other keep their momentum", "[rope][links]") {
  World w(vacuum(Vec3(0, 0, 0)), catalog());
  Rope& rope = w.need<Rope>();
  const ObjectId line = rope.add_rope(straight_rope(vec3(-1, 0, 0), vec3(0, 0, 0), 10));
  ClothDesc sheet;
  sheet.size[0] = sheet.size[1] = 1, sheet.nx = sheet.ny = 11;
  sheet.wind = false;
  sheet.pose.position = vec3(Real(0.5), 0, 0);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId cloth_id = cloth.add_cloth(sheet);
  const ObjectId net = w.need<Springs>().add_net(net_between(vec3(1, 0, 0), vec3(2, 0, 0)));
  const ObjectId second = rope.add_rope(straight_rope(vec3(2, 0, 0), vec3(2, 1, 0), 10));
  rope.attach_point(line, 10, cloth_id, 5 * 11);  // the middle of the left side
  w.need<Springs>().attach_point(net, 0, cloth_id, 5 * 11 + 10);
  rope.attach_point(second, 0, net, 1);
  for (std::size_t i = 0; i <= 10; ++i) rope.set_velocity(line, i, vec3(-1, 0, Real(0.5)));
  for (std::size_t i = 0; i <= 10; ++i) rope.set_velocity(second, i, vec3(1, 2, 0));
  const Momentum before = w.momentum();
  for (int i = 0; i < 60; ++i) w.step();
  const Momentum after = w.momentum();
  double mass_speed = 0;
  for (std::size_t i = 0; i <= 10; ++i) mass_speed += number(rope.point_mass(line, i)) * 2;
  for (int k = 0; k < 3; ++k) CHECK(std::fabs(after.linear[k] - before.linear[k]) < 1e-5 * mass_speed + 1e-6);
  const auto gap = [](const Vec3& a, const Vec3& b) { return number(length(Vec3(a - b))); };
  CHECK(gap(rope.point(line, 10), cloth.point(cloth_id, 5 * 11)) < 0.005);
  CHECK(gap(w.need<Springs>().point(net, 0), cloth.point(cloth_id, 5 * 11 + 10)) < 0.005);
  CHECK(gap(w.need<Springs>().point(net, 1), rope.point(second, 0)) < 0.005);
  // all three go along
  CHECK(number(cloth.velocity(cloth_id, 60)[0]) != 0);
  // ended from the other side, they part
  cloth.detach(cloth_id, 5 * 11);
  for (std::size_t i = 0; i <= 10; ++i) rope.set_velocity(line, i, vec3(-5, 0, 0));
  for (int i = 0; i < 20; ++i) w.step();
  CHECK(gap(rope.point(line, 10), cloth.point(cloth_id, 5 * 11)) > 0.05);
}

TEST_CASE("a body hangs from a rope with the tension that its weight says", "[rope][links]") {
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = straight_rope(vec3(0, 2, 0), vec3(0, 1, 0), 20);
  d.pins = {0};
  const ObjectId id = rope.add_rope(d);
  BodyDesc ball;
  ball.shape = make_sphere(Real(0.1)), ball.mass = 50;
  ball.position = vec3(0, Real(0.9), 0);
  const ObjectId body = w.need<Rigid>().add_body(ball);
  rope.attach(id, 20, body, vec3(0, Real(0.1), 0));
  for (int i = 0; i < 240; ++i) w.step();
  const double weight = 50 * 9.81;
  CHECK(std::fabs(number(rope.tension(id, 10)) / weight - 1) < 0.02);
  const Bodies& b = w.need<Rigid>().bodies();
  const Real fallen = Real(0.9) - b.position[w.need<Rigid>().index(body)][1];
  CHECK(std::fabs(number(fallen) / (weight / 50000) - 1) < 0.15);  // E A = 50000 N, 1 m long
}

TEST_CASE("a rope of short segments does not press on what it hangs from", "[rope][links]") {
  // in a V from the side of a box to a pin, with a ball round its middle; segments are a third of its thickness
  const bool pinned = GENERATE(false, true);  // at the box, or attached to it
  CAPTURE(pinned);
  World w(vacuum(), catalog());
  RopeDesc d;
  for (int i = 0; i <= 160; ++i) {
    const Real share = static_cast<Real>(i) / 160;
    d.points.push_back(vec3(Real(0.8) * share, Real(0.3) * (std::fabs(2 * share - 1) - 1), 0));
  }
  d.radius = Real(0.0075), d.density = 100, d.self_collision = false, d.pins = {160};
  if (pinned) d.pins.push_back(0);
  Rope& rope = w.need<Rope>();
  const ObjectId id = rope.add_rope(d);
  BodyDesc box;
  box.type = BodyType::fixed, box.shape = make_box(Real(0.2), Real(0.2), Real(0.2));
  box.position = vec3(Real(-0.1), 0, 0);
  const ObjectId wall = w.need<Rigid>().add_body(box);
  BodyDesc ball;
  ball.shape = make_sphere(Real(0.04)), ball.mass = 20;
  ball.position = rope.point(id, 80);
  const ObjectId load = w.need<Rigid>().add_body(ball);
  if (!pinned) rope.attach(id, 0, wall, vec3(Real(0.1), 0, 0));
  rope.attach(id, 80, load, vec3(0, 0, 0));
  for (int i = 0; i < 300; ++i) w.step();
  const double tension = 20 * 9.81 / 2 / 0.6;
  for (std::size_t k = 0; k < 160; ++k) {
    CAPTURE(k);
    CHECK(std::fabs(number(rope.tension(id, k)) / tension - 1) < 0.02);
  }
  // as straight as a rope under that load is: no point is pushed aside
  for (std::size_t i = 1; i < 80; ++i) {
    const Vec3 a = rope.point(id, 0), b = rope.point(id, 80), p = rope.point(id, i);
    CHECK(number(length(cross(p - a, b - a)) / length(Vec3(b - a))) < 0.001);
  }
}

TEST_CASE("a gap of an attachment is a warning that names both", "[rope][links]") {
  World w(WorldDesc{}, catalog());
  Rope& rope = w.need<Rope>();
  RopeDesc d = straight_rope(vec3(0, 2, 0), vec3(1, 2, 0), 10);
  d.name = "left", d.pins = {0};
  const ObjectId left = rope.add_rope(d);
  d = straight_rope(vec3(Real(1.4), 2, 0), vec3(2, 2, 0), 10);
  d.name = "right";
  const ObjectId right = rope.add_rope(d);
  rope.attach_point(left, 10, right, 0);
  w.step();
  CHECK(warnings(w, "\"left\"") == 1);
  CHECK(warnings(w, "\"right\"") == 1);
  for (int i = 0; i < 120; ++i) w.step();
  CHECK(number(length(Vec3(rope.point(left, 10) - rope.point(right, 0)))) < 0.02);  // drawn together
  CHECK_THROWS_AS(rope.attach_point(left, 11, right, 0), SceneError);
  CHECK_THROWS_AS(rope.attach_point(left, 1, left, 1), SceneError);
}

TEST_CASE("attachments go on from a snapshot", "[rope][links]") {
  std::uint64_t hashes[2];
  for (int k = 0; k < 2; ++k) {
    World w(WorldDesc{}, catalog());
    Rope& rope = w.need<Rope>();
    RopeDesc d = straight_rope(vec3(0, 2, 0), vec3(1, 2, 0), 10);
    d.pins = {0};
    const ObjectId a = rope.add_rope(d), b = rope.add_rope(straight_rope(vec3(1, 2, 0), vec3(2, 2, 0), 10));
    rope.attach_point(a, 10, b, 0);
    for (int i = 0; i < 10; ++i) w.step();
    if (k == 1) {
      const std::string image = w.snapshot();
      rope.detach(a, 10);
      for (int i = 0; i < 10; ++i) w.step();
      w.restore(image);
    }
    for (int i = 0; i < 20; ++i) w.step();
    hashes[k] = w.hash();
  }
  CHECK(hashes[0] == hashes[1]);
}

}  // namespace feder::test
