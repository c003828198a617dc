// Friction, rolling and driven surfaces against closed forms.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

// A plane through the origin that falls towards +x by `angle`, and the directions down and off it.
struct Incline {
  double angle;
  Quat turn;
  Vec3 down, normal;
  explicit Incline(double a) : angle(a), turn(from_axis_angle(Vec3(0, 0, 1), Real(-a))) {
    down = rotate(turn, Vec3(1, 0, 0));
    normal = rotate(turn, Vec3(0, 1, 0));
  }
};

double along(const Vec3& v, const Vec3& d) { return double(dot(v, d)); }

}  // namespace

TEST_CASE("a block holds on an incline up to the friction angle, and slides beyond", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double degrees = GENERATE(25.0, 35.0);
  CAPTURE(solver, degrees);
  const Incline slope(degrees * 3.14159265358979 / 180);
  for (const double mu : {0.3, 0.95 * std::tan(slope.angle), 1.05 * std::tan(slope.angle)}) {
    CAPTURE(mu);
    ClosedScene s(solver);
    s.rigid().add_body(ground_of(Real(mu), slope.normal));
    BodyDesc d = body_of(make_box(1, Real(0.5), 1), Real(0.25) * slope.normal, 1, Real(mu));
    d.rotation = slope.turn;
    const ObjectId block = s.rigid().add_body(d);
    s.run(0.5);
    const double v0 = along(s.velocity(block), slope.down), x0 = along(s.position(block), slope.down);
    s.run(1);
    const double v = along(s.velocity(block), slope.down) - v0;
    const double travel = along(s.position(block), slope.down) - x0;
    if (mu > std::tan(slope.angle)) {
      CHECK(std::abs(v) < 1e-3);
      CHECK(std::abs(travel) < 1e-3);
    } else {
      const double a = kG * (std::sin(slope.angle) - mu * std::cos(slope.angle));
      CHECK(v == Approx(a).epsilon(closed_tolerance(solver).friction));
      CHECK(travel == Approx(v0 + a / 2).epsilon(closed_tolerance(solver).friction).margin(a * s.h()));
    }
  }
}

TEST_CASE("static friction holds what dynamic friction would not", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  const Incline slope(0.35);  // tan = 0.365
  const auto slide = [&](double start) {
    ClosedScene s(solver);
    BodyDesc ground = ground_of(Real(0.6), slope.normal);
    ground.friction_dynamic = Real(0.2);
    s.rigid().add_body(ground);
    BodyDesc d = body_of(make_box(1, Real(0.5), 1), Real(0.25) * slope.normal, 1, Real(0.6));
    d.friction_dynamic = Real(0.2);
    d.rotation = slope.turn;
    d.velocity = Real(start) * slope.down;
    const ObjectId block = s.rigid().add_body(d);
    s.run(1);
    return along(s.velocity(block), slope.down);
  };
  CHECK(std::abs(slide(0)) < 1e-3);
  const double a = kG * (std::sin(slope.angle) - 0.2 * std::cos(slope.angle));
  CHECK(slide(2) == Approx(2 + a).epsilon(closed_tolerance(solver).friction));
}

// v^2 / (2 mu g) and v / (mu g) in twelve headings, straight and without yaw.
TEST_CASE("stopping distance is the same in all headings", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double mu = GENERATE(0.3, 0.8);
  CAPTURE(solver, mu);
  const double v = 3;
  for (int k = 0; k < 12; ++k) {
    const double heading = k * 3.14159265358979 / 6;
    CAPTURE(k);
    ClosedScene s(solver, 1.0 / 240, 4);
    s.rigid().add_body(ground_of(Real(mu)));
    BodyDesc d = body_of(make_box(Real(0.4), Real(0.2), Real(0.4)), Vec3(0, Real(0.1), 0), 1, Real(mu));
    Real c, sn;
    sin_cos(Real(heading), sn, c);
    const Vec3 direction(c, 0, sn);
    d.velocity = Real(v) * direction;
    const ObjectId block = s.rigid().add_body(d);
    double stop = 0;
    for (int i = 0; i < 2 * 240; ++i) {
      s.world().step();
      if (length(s.velocity(block)) > Real(0.02)) stop = s.world().time();
    }
    const Vec3 end = s.position(block);
    CHECK(along(end, direction) == Approx(v * v / (2 * mu * kG)).epsilon(closed_tolerance(solver).friction));
    CHECK(stop == Approx(v / (mu * kG)).epsilon(0.02));
    CHECK(length(Vec3(end - dot(end, direction) * direction - dot(end, Vec3(0, 1, 0)) * Vec3(0, 1, 0))) < Real(0.003));
    CHECK(length(rotation_between(Quat{}, s.rotation(block))) < Real(0.005));
  }
}

// A sliding sphere rolls after 2 v / (7 mu g) with 5/7 of its speed.
TEST_CASE("slide to roll", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int dimension = GENERATE(2, 3);
  CAPTURE(solver, dimension);
  const double v = 2, mu = 0.5, r = 0.1;
  ClosedScene s(solver, 1.0 / 240, 4, dimension);
  const bool planar = dimension == 2;
  BodyDesc ground = ground_of(Real(mu));
  if (planar) ground.shape = make_polygon(std::vector<Vec2>{Vec2(-9, -1), Vec2(9, -1), Vec2(9, 0), Vec2(-9, 0)});
  s.rigid().add_body(ground);
  BodyDesc d = body_of(planar ? make_circle(Real(r)) : make_sphere(Real(r)), Vec3(0, Real(r), 0), 1, Real(mu));
  d.velocity = Vec3(Real(v), 0, 0);
  const ObjectId ball = s.rigid().add_body(d);
  const double share = planar ? 1.0 / 3 : 2.0 / 7, t = share * v / (mu * kG);
  double rolls = 0;
  for (int i = 0; i < 240; ++i) {
    s.world().step();
    const double slip = s.velocity(ball)[0] + r * s.spin(ball)[2];
    if (slip > 0.01) rolls = s.world().time();
  }
  CHECK(rolls == Approx(t).margin(2.0 / 240));
  CHECK(s.velocity(ball)[0] == Approx((1 - share) * v).epsilon(closed_tolerance(solver).rolling));
  CHECK(s.velocity(ball)[0] + r * s.spin(ball)[2] == Approx(0).margin(1e-3));
}

// a = g sin / (1 + I / m r^2), and the friction needed for it is tan / (1 + m r^2 / I).
TEST_CASE("rolling down an incline", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const bool cylinder = GENERATE(false, true);
  CAPTURE(solver, cylinder);
  const Incline slope(3.14159265358979 / 6);
  const double r = 0.2, k = cylinder ? 0.5 : 0.4, needed = std::tan(slope.angle) / (1 + 1 / k);
  for (const double mu : {1.2 * needed, 0.5 * needed}) {
    CAPTURE(mu);
    ClosedScene s(solver, 1.0 / 240, 4);
    s.rigid().add_body(ground_of(Real(mu), slope.normal));
    BodyDesc d =
        body_of(cylinder ? make_cylinder(Real(r), 1) : make_sphere(Real(r)), Real(r) * slope.normal, 1, Real(mu));
    if (cylinder) d.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 2);
    const ObjectId body = s.rigid().add_body(d);
    s.run(1);
    const double a =
        mu > needed ? kG * std::sin(slope.angle) / (1 + k) : kG * (std::sin(slope.angle) - mu * std::cos(slope.angle));
    CHECK(along(s.velocity(body), slope.down) == Approx(a).epsilon(closed_tolerance(solver).rolling));
    if (mu > needed) CHECK(-double(s.spin(body)[2]) * r == Approx(a).epsilon(closed_tolerance(solver).rolling));
  }
}

// A crate on a belt has its speed after v / (mu g) and has slipped v^2 / (2 mu g) by then.
TEST_CASE("conveyor", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  const double v = 2, mu = 0.4;
  ClosedScene s(solver, 1.0 / 240, 4);
  BodyDesc belt = body_of(make_box(40, 1, 4), Vec3(0, Real(-0.5), 0), 0, Real(mu));
  belt.type = BodyType::fixed;
  belt.surface_velocity = Vec3(Real(v), 0, 0);
  s.rigid().add_body(belt);
  const ObjectId crate =
      s.rigid().add_body(body_of(make_box(Real(0.4), Real(0.2), Real(0.4)), Vec3(0, Real(0.1), 0), 2, Real(mu)));
  double reached = 0;
  for (int i = 0; i < 480; ++i) {
    s.world().step();
    if (s.velocity(crate)[0] < 0.99 * v) reached = s.world().time();
  }
  CHECK(reached == Approx(0.99 * v / (mu * kG)).margin(3.0 / 240));
  CHECK(s.velocity(crate)[0] == Approx(v).epsilon(1e-3));
  CHECK(s.position(crate)[0] == Approx(v * 2 - v * v / (2 * mu * kG)).epsilon(closed_tolerance(solver).friction));
}

// A ball on a slope starts to roll iff tan > arm / r.
TEST_CASE("rolling resistance", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  const Incline slope(0.15);
  const double r = 0.2, limit = std::tan(slope.angle);
  for (const double ratio : {0.8, 1.2}) {
    CAPTURE(ratio);
    ClosedScene s(solver, 1.0 / 240, 4);
    BodyDesc ground = ground_of(1, slope.normal);
    ground.rolling_friction = Real(ratio * limit * r);
    s.rigid().add_body(ground);
    BodyDesc d = body_of(make_sphere(Real(r)), Real(r) * slope.normal, 1, 1);
    d.rolling_friction = Real(ratio * limit * r);
    const ObjectId ball = s.rigid().add_body(d);
    s.run(1);
    // the couple takes arm * N / (I + m r^2) off the angular acceleration
    const double a = ratio < 1 ? kG * (std::sin(slope.angle) - ratio * limit * std::cos(slope.angle)) / 1.4 : 0;
    CHECK(along(s.velocity(ball), slope.down) == Approx(a).epsilon(2 * closed_tolerance(solver).rolling).margin(2e-3));
  }
}
