// Impacts against closed forms: central impact, corner hit of a rod, series of bounces.
#include "rigid/closed_scene.h"

using namespace feder;

TEST_CASE("head-on impacts of spheres", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double e = GENERATE(0.0, 0.5, 1.0);
  CAPTURE(solver, e);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  const double m1 = 2, m2 = 5, v1 = 3, v2 = -1;
  BodyDesc d = body_of(make_sphere(Real(0.5)), Vec3(-1, 0, 0), Real(m1));
  d.restitution = Real(e);
  d.velocity = Vec3(Real(v1), 0, 0);
  const ObjectId a = s.rigid().add_body(d);
  d.position = Vec3(1, 0, 0);
  d.mass = Real(m2);
  d.velocity = Vec3(Real(v2), 0, 0);
  const ObjectId b = s.rigid().add_body(d);
  s.run(1);
  const double tolerance = closed_tolerance(solver).impact;
  CHECK(s.velocity(a)[0] == Approx(((m1 - e * m2) * v1 + (1 + e) * m2 * v2) / (m1 + m2)).margin(tolerance * 4));
  CHECK(s.velocity(b)[0] == Approx(((m2 - e * m1) * v2 + (1 + e) * m1 * v1) / (m1 + m2)).margin(tolerance * 4));
}

// j = (1 + e) v / (1/m + x^2 / I) for a frictionless hit at the lever x: a rod tilted by 30 degrees meets the ground
// with its lower end.
TEST_CASE("corner hit of a rod", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double e = GENERATE(0.0, 0.6);
  const int dimension = GENERATE(2, 3);
  CAPTURE(solver, e, dimension);
  ClosedScene s(solver, 1.0 / 240, 4, dimension);
  s.desc.gravity = Vec3::Zero();
  const Real angle = kPi / 6;
  const double w = 2, t = 0.1, v = 2, m = 3;
  std::vector<Vec2> section = {Vec2(-1, Real(-0.05)), Vec2(1, Real(-0.05)), Vec2(1, Real(0.05)), Vec2(-1, Real(0.05))};
  BodyDesc ground;
  ground.type = BodyType::fixed;
  ground.shape = dimension == 2 ? make_polygon(std::vector<Vec2>{Vec2(-5, -1), Vec2(5, -1), Vec2(5, 0), Vec2(-5, 0)})
                                : make_plane(Vec3(0, 1, 0), 0);
  ground.friction_static = ground.friction_dynamic = 0;
  s.rigid().add_body(ground);
  // lower end: half length down the rod, half thickness across. In space a diamond section gives one corner.
  BodyDesc d = body_of(dimension == 2 ? make_polygon(section) : make_capsule(Real(0.05), 2), Vec3(0, 1, 0), Real(m));
  const bool planar = dimension == 2;
  d.rotation = planar ? from_axis_angle(Vec3(0, 0, 1), angle) : from_axis_angle(Vec3(0, 0, 1), angle - kPi / 2);
  d.velocity = Vec3(0, Real(-v), 0);
  d.restitution = Real(e);
  const ObjectId rod = s.rigid().add_body(d);
  const double inertia = s.rigid().inertia(rod)(2, 2);
  if (planar) CHECK(inertia == Approx(m / 12 * (w * w + t * t)).epsilon(1e-4));
  // lever arm of the contact point: 2D corner (-1, -0.05) rotated; 3D centre of the capsule's lower cap
  const double c = std::sqrt(3.0) / 2, half = planar ? 1.0 : 0.95;
  const double x = planar ? -half * c + 0.05 * 0.5 : -half * c;
  const double j = (1 + e) * v / (1 / m + x * x / inertia);
  for (int k = 0; k < 240 && std::abs(s.spin(rod)[2]) < 1e-6; ++k) s.world().step();
  s.world().step();
  const double tolerance = std::max(closed_tolerance(solver).impact, 0.0) * 5;  // the rod rotates during contact
  CHECK(s.velocity(rod)[1] == Approx(-v + j / m).margin(tolerance * v));
  CHECK(s.spin(rod)[2] == Approx(x * j / inertia).margin(tolerance * v));
}

// The n-th apex is e^2n of the drop height, the energy after it e^2 of the one before.
TEST_CASE("bounce series", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double e = GENERATE(0.3, 0.5, 0.8, 0.95);
  CAPTURE(solver, e);
  ClosedScene s(solver, 1.0 / 240, 4);
  s.rigid().add_body(ground_of(0));
  const double radius = 0.1;
  BodyDesc d = body_of(make_sphere(Real(radius)), Vec3(0, Real(5 + radius), 0));
  d.restitution = Real(e);
  const ObjectId ball = s.rigid().add_body(d);
  std::vector<double> apexes;
  double v_before = 0, y_before = 5;
  // bounces slower than 1.5 m/s may count as rest
  const int wanted = e < 0.4 ? 1 : e < 0.6 ? 2 : 4;
  for (int k = 0; k < 240 * 12 && int(apexes.size()) < wanted; ++k) {
    s.world().step();
    const double v = s.velocity(ball)[1], y = s.position(ball)[1] - radius;
    if (k > 1 && v_before > 0 && v <= 0) apexes.push_back(std::max(y, y_before));
    v_before = v;
    y_before = y;
  }
  REQUIRE(int(apexes.size()) == wanted);
  double expected = 5;
  for (std::size_t i = 0; i < apexes.size(); ++i) {
    CAPTURE(i);
    const double before = i ? apexes[i - 1] : 5;
    expected *= e * e;
    CHECK(apexes[i] == Approx(expected).epsilon(closed_tolerance(solver).apex * double(i + 1)));
    CHECK(apexes[i] / before == Approx(e * e).epsilon(closed_tolerance(solver).apex));
  }
}

// A blow passes through balls in a row: the last leaves with the speed of the first (Newton). Gaps within a contact's
// margin, touching balls, and gaps of several steps.
TEST_CASE("Newton's cradle", "[rigid][closed]") {
  const int balls = GENERATE(3, 5, 7);
  const double gap = GENERATE(0.0, 0.001, 0.05), v = GENERATE(0.5, 2.0, 6.0);
  CAPTURE(balls, gap, v);
  ClosedScene s("soft_step", 1.0 / 60);
  s.desc.gravity = Vec3::Zero();
  std::vector<ObjectId> row;
  for (int k = 0; k < balls; ++k) {
    BodyDesc d = body_of(make_sphere(Real(0.1)), Vec3(Real(k ? k * (0.2 + gap) : -0.5), 0, 0), 1);
    d.restitution = 1;
    d.velocity = Vec3(Real(k ? 0 : v), 0, 0);
    row.push_back(s.rigid().add_body(d));
  }
  s.run(1.5 / v + 0.5);
  for (int k = 0; k < balls; ++k)
    CHECK(s.velocity(row[std::size_t(k)])[0] == Approx(k + 1 == balls ? v : 0).margin(1e-4 * v));
}

// Balls of mass 1 and `ratio` between a wall and infinity: the number of collisions is the digits of pi for ratios of
// 100^n (Galperin 2003); for others it follows from the angle arctan(1 / sqrt(ratio)).
TEST_CASE("elastic collisions between a wall and a heavy ball are counted right", "[rigid][closed]") {
  struct Row {
    double ratio;
    int count;
  };
  const Row row = GENERATE(Row{1, 3}, Row{16, 12}, Row{100, 31});
  CAPTURE(row.ratio);
  ClosedScene s("soft_step", 1.0 / 60);
  s.desc.gravity = Vec3::Zero();
  s.desc.sleeping = true;  // the light ball is asleep when it is hit
  BodyDesc wall;
  wall.type = BodyType::fixed;
  wall.shape = make_box(1, 10, 10);
  wall.position = Vec3(Real(-0.5), 0, 0);
  wall.restitution = 1;
  s.rigid().add_body(wall);
  BodyDesc d = body_of(make_sphere(Real(0.1)), Vec3(1, 0, 0), 1);
  d.restitution = 1;
  const ObjectId light = s.rigid().add_body(d);
  d.position = Vec3(3, 0, 0);
  d.mass = Real(row.ratio);
  d.velocity = Vec3(-1, 0, 0);
  const ObjectId heavy = s.rigid().add_body(d);
  int begins = 0;
  for (int k = 0; k < 60 * 12; ++k) {
    s.world().step();
    for (const Event& e : s.world().events().list()) begins += e.kind == EventKind::contact_begin;
  }
  CHECK(begins == row.count);
  const double a = double(s.velocity(light)[0]), b = double(s.velocity(heavy)[0]);
  CHECK(a * a + row.ratio * b * b == Approx(row.ratio).epsilon(1e-4));
}
