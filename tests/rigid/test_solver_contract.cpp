// Every registered solver: what a solver must hold whatever its method. A new one is enrolled by its line alone.
#include <cmath>

#include "rigid/closed_scene.h"

using namespace feder;

TEST_CASE("solver: free fall is the integrator's sum", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row));
  const ObjectId id = s.rigid().add_body(body_of(make_sphere(1), Vec3(0, 50, 0)));
  for (int i = 0; i < 60; ++i) s.world().step();
  const double t = 1, h = s.h();
  CHECK(static_cast<double>(s.position(id)[1]) == Approx(50 - 0.5 * kG * t * t - 0.5 * kG * h * t).epsilon(1e-5));
}

TEST_CASE("solver: a closed system keeps its momentum", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row));
  s.desc.gravity = Vec3::Zero();
  // a cluster drawn together by its own speeds, with two jointed pairs in it
  std::vector<ObjectId> ids;
  double size = 0;
  for (int i = 0; i < 12; ++i) {
    const Vec3 at(Real(i % 3) * Real(1.5) - Real(1.5), Real(i / 3) * Real(1.5) - 2, Real(i % 2) * Real(0.3));
    BodyDesc d = body_of(i % 4 == 0 ? make_sphere(Real(0.5)) : make_box(1, 1, 1), at, Real(1 + i % 3), Real(0.5));
    d.velocity = at * Real(-0.5) + Vec3(Real(0.3), 0, 0);
    d.restitution = Real(0.3);
    ids.push_back(s.rigid().add_body(d));
    size += static_cast<double>(d.mass) * static_cast<double>(length(d.velocity));
  }
  for (const int k : {0, 6}) {
    JointDesc j;
    j.type = "ball";
    j.a = ids[static_cast<std::size_t>(k)], j.b = ids[static_cast<std::size_t>(k + 1)];
    j.anchor_a = (s.position(j.a) + s.position(j.b)) / 2;
    s.rigid().add_joint(j);
  }
  const Momentum before = s.world().momentum();
  const int steps = 10000;
  for (int i = 0; i < steps; ++i) s.world().step();
  const Momentum after = s.world().momentum();
  const double tolerance = sizeof(Real) == 8 ? 1e-9 : 2e-3;  // rounding of 10,000 steps
  for (int k = 0; k < 3; ++k) CHECK(after.linear[k] == Approx(before.linear[k]).margin(tolerance * size));
  REQUIRE(s.world().is_finite());
}

TEST_CASE("solver: sliding friction decelerates by mu g in every direction", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  const int heading = GENERATE(range(0, 6));
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row), heading);
  s.rigid().add_body(ground_of(Real(0.3)));
  Real sn, cs;
  sin_cos(Real(heading) * kPi / 6, sn, cs);
  BodyDesc d = body_of(make_box(1, Real(0.2), 1), Vec3(0, Real(0.1), 0), 5, Real(0.3));
  d.velocity = Vec3(4 * cs, 0, 4 * sn);
  const ObjectId id = s.rigid().add_body(d);
  s.run(0.5);
  CHECK(static_cast<double>(length(s.velocity(id))) == Approx(4 - 0.3 * kG * 0.5).epsilon(0.02));
  s.run(2);
  CHECK(length(s.velocity(id)) < Real(0.01));
  const Vec3 p = s.position(id);
  CHECK(static_cast<double>(std::sqrt(p[0] * p[0] + p[2] * p[2])) == Approx(16 / (2 * 0.3 * kG)).epsilon(0.02));
  CHECK(static_cast<double>(std::fabs(p[0] * sn - p[2] * cs)) < 0.01);
}

TEST_CASE("solver: static friction holds where dynamic friction would slide", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row));
  // a slope of 25 degrees: tan = 0.466
  s.desc.gravity = Vec3(Real(9.81 * 0.42261826), Real(-9.81 * 0.90630779), 0);
  BodyDesc ground = ground_of(1);
  s.rigid().add_body(ground);
  BodyDesc d = body_of(make_box(1, Real(0.5), 1), Vec3(0, Real(0.25), 0), 1, 1);
  d.friction_static = Real(0.6), d.friction_dynamic = Real(0.3);
  d.friction_static *= d.friction_static, d.friction_dynamic *= d.friction_dynamic;  // mixed with 1 by sqrt
  const ObjectId rests = s.rigid().add_body(d);
  d.position[2] = 3;
  d.velocity = Vec3(2, 0, 0);
  const ObjectId slides = s.rigid().add_body(d);
  s.run(1);
  CHECK(length(s.velocity(rests)) < Real(0.01));
  CHECK(static_cast<double>(s.velocity(slides)[0]) == Approx(2 + kG * (0.42261826 - 0.3 * 0.90630779)).epsilon(0.03));
}

TEST_CASE("solver: a stack of ten stands", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row));
  s.rigid().add_body(ground_of(Real(0.6)));
  std::vector<ObjectId> ids;
  for (int i = 0; i < 10; ++i)
    ids.push_back(s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(0, Real(0.5) + Real(i), 0), 1, Real(0.6))));
  s.run(5);
  for (int i = 0; i < 10; ++i) {
    const Vec3 p = s.position(ids[static_cast<std::size_t>(i)]);
    CAPTURE(i);
    CHECK(static_cast<double>(p[1]) == Approx(0.5 + i).margin(0.05));
    CHECK(static_cast<double>(std::hypot(p[0], p[2])) < 0.01);
  }
}

TEST_CASE("solver: a ball leaves with e times its approach speed", "[rigid][contract]") {
  const int row = GENERATE(range(0, solver_count()));
  const double e = GENERATE(0.0, 0.3, 0.5, 0.8, 0.95);
  ClosedScene s(solver_name(row));
  CAPTURE(solver_name(row), e);
  s.desc.gravity = Vec3::Zero();
  s.rigid().add_body(ground_of(0));
  BodyDesc d = body_of(make_sphere(Real(0.5)), Vec3(0, 2, 0));
  d.velocity = Vec3(0, -5, 0);
  d.restitution = static_cast<Real>(e);
  const ObjectId id = s.rigid().add_body(d);
  s.run(1);
  CHECK(static_cast<double>(s.velocity(id)[1]) == Approx(5 * e).margin(0.02));
}

TEST_CASE("solver: the same bits for one, two and four threads", "[rigid][contract][threads]") {
  const int row = GENERATE(range(0, solver_count()));
  CAPTURE(solver_name(row));
  std::uint64_t first = 0;
  for (const int threads : {1, 2, 4}) {
    ClosedScene s(solver_name(row));
    s.desc.threads = threads;
    s.rigid().add_body(ground_of(Real(0.5)));
    for (int i = 0; i < 12; ++i)
      for (int k = 0; k < 12; ++k)
        for (int j = 0; j < 3; ++j)
          s.rigid().add_body(body_of(make_box(1, 1, 1),
                                     Vec3(Real(1.02) * Real(i), Real(0.6) + Real(j) * Real(1.1), Real(1.02) * Real(k)),
                                     1, Real(0.5)));
    for (int step = 0; step < 40; ++step) s.world().step();
    if (threads == 1) first = s.world().hash();
    CAPTURE(threads);
    CHECK(s.world().hash() == first);
  }
}
