// Free motion against closed forms: fall, rotation, mass properties, conserved quantities.
#include "base/rng.h"
#include "rigid/closed_scene.h"

using namespace feder;

TEST_CASE("free fall is the sum of the integrator", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int dimension = GENERATE(2, 3);
  CAPTURE(solver, dimension);
  ClosedScene s(solver, 1.0 / 60, 4, dimension);
  const ObjectId ball = [&] {
    BodyDesc d = body_of(dimension == 2 ? make_circle(Real(0.1)) : make_sphere(Real(0.1)), Vec3(0, 10, 0));
    d.velocity = Vec3(2, 3, 0);
    return s.rigid().add_body(d);
  }();
  s.run(2);
  const double t = 2;
  CHECK(s.velocity(ball)[1] == Approx(3 - kG * t).epsilon(200 * kEpsilon));
  CHECK(s.position(ball)[1] == Approx(10 + 3 * t - kG * t * (t + s.h()) / 2).epsilon(2000 * kEpsilon));
  CHECK(s.position(ball)[0] == Approx(4).epsilon(200 * kEpsilon));
}

TEST_CASE("a torque and a force act for one step", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  const ObjectId box = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3::Zero(), 3));
  s.rigid().apply_force(box, Vec3(6, 0, 0), nullptr);
  s.rigid().apply_torque(box, Vec3(0, 0, 2));
  for (int i = 0; i < 10; ++i) s.world().step();
  CHECK(s.velocity(box)[0] == Approx(6.0 / 3 / 60).epsilon(1e-5));
  CHECK(s.spin(box)[2] == Approx(2.0 / (3 * (1.0 + 1.0) / 12) / 60).epsilon(1e-5));
}

TEST_CASE("inertia of a box and of its hull", "[rigid][closed]") {
  ClosedScene s(solver_name(0));
  const Real m = 6, a = 1, b = 2, c = 3;
  std::vector<Vec3> corners;
  for (const Real x : {-a, a})
    for (const Real y : {-b, b})
      for (const Real z : {-c, c}) corners.push_back(Vec3(x, y, z) / 2);
  for (const ShapePtr& shape : {make_box(a, b, c), make_hull(corners)}) {
    CAPTURE(shape->kind());
    const Mat3 i = s.rigid().inertia(s.rigid().add_body(body_of(shape, Vec3(0, 5, 0), m)));
    CHECK(i(0, 0) == Approx(m / 12 * (b * b + c * c)).epsilon(1e-5));
    CHECK(i(1, 1) == Approx(m / 12 * (a * a + c * c)).epsilon(1e-5));
    CHECK(i(2, 2) == Approx(m / 12 * (a * a + b * b)).epsilon(1e-5));
    for (int j = 0; j < 3; ++j) CHECK(i(j, (j + 1) % 3) == Approx(0).margin(1e-5));
  }
}

namespace {

// Kinetic energy and angular momentum of one spinning body, in double.
void angular_velocity_of(ClosedScene& s, ObjectId b, double& energy, double& momentum) {
  const Mat3 inertia = s.rigid().inertia(b);
  const Vec3 w = rotate_inverse(s.rotation(b), s.spin(b));
  const Vec3 l = inertia * w;
  energy = double(dot(w, l)) / 2;
  momentum = double(length(l));
}

struct Top {
  Vec3 half, spin;
  double period;
};

}  // namespace

TEST_CASE("a free top keeps energy and angular momentum, and flips on time", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  // periods of the angular velocity in the body, exact by elliptic integrals (Jacobi 1849)
  const Top top = GENERATE(Top{Vec3(Real(0.1), Real(0.2), Real(0.3)), Vec3(Real(0.05), 5, Real(0.05)), 10.2203046},
                           Top{Vec3(Real(0.1), Real(0.2), Real(0.3)), Vec3(Real(0.01), 10, 0), 6.60126439},
                           Top{Vec3(Real(0.35), Real(0.08), Real(0.5)), Vec3(5, Real(0.01), Real(0.01)), 10.5603943});
  CAPTURE(solver, top.period);
  ClosedScene s(solver, 0.005, 1);
  s.desc.gravity = Vec3::Zero();
  BodyDesc d = body_of(make_box(2 * top.half[0], 2 * top.half[1], 2 * top.half[2]), Vec3::Zero());
  d.angular_velocity = top.spin;
  const ObjectId b = s.rigid().add_body(d);
  double energy0, momentum0;
  angular_velocity_of(s, b, energy0, momentum0);
  const Vec3 direction0 = rotate(s.rotation(b), Vec3(s.rigid().inertia(b) * top.spin)) / Real(momentum0);
  int axis = 0;
  top.spin.cwiseAbs().maxCoeff(&axis);
  std::vector<double> flips;
  double before = top.spin[axis], worst_energy = 0, worst_momentum = 0, worst_direction = 0;
  for (int k = 1; k <= 5000; ++k) {
    s.world().step();
    const Vec3 w = rotate_inverse(s.rotation(b), s.spin(b));
    const double now = w[axis];
    if (before * now < 0) flips.push_back((k - 1 + before / (before - now)) * 0.005);
    before = now;
    double energy, momentum;
    angular_velocity_of(s, b, energy, momentum);
    worst_energy = std::max(worst_energy, std::abs(energy / energy0 - 1));
    worst_momentum = std::max(worst_momentum, std::abs(momentum / momentum0 - 1));
    const Vec3 l = rotate(s.rotation(b), Vec3(s.rigid().inertia(b) * w));
    worst_direction = std::max(worst_direction, double(length(l / length(l) - direction0)));
  }
  CHECK(worst_energy < 0.01);
  CHECK(worst_momentum < 1e-3);
  CHECK(worst_direction < 1e-3);
  // the period hangs on L^2 - 2 E I_2, which is 1e-5 (second top: 4e-7) of L^2: less than float keeps of either
  REQUIRE(flips.size() >= 3);
  for (std::size_t k = 2; k < flips.size(); ++k) CHECK(flips[k] - flips[k - 2] == Approx(top.period).epsilon(0.003));
}

TEST_CASE("momentum and angular momentum last 10000 steps with joints and contacts", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  Rigid& rigid = s.rigid();
  Rng rng(4);
  // a chain of boxes on balls, hinges, springs and welds; its ends and the spheres between knock into each other
  std::vector<ObjectId> link;
  for (int i = 0; i < 6; ++i) {
    BodyDesc d =
        body_of(make_box(Real(0.4), Real(0.2), Real(0.3)), Vec3(Real(0.5) * Real(i), 0, 0), Real(1 + i % 3), Real(0.4));
    d.velocity = draw(rng, 1);
    d.angular_velocity = draw(rng, 1);
    link.push_back(rigid.add_body(d));
  }
  const char* const kinds[] = {"ball", "hinge", "distance", "weld", "ball"};
  for (int i = 0; i < 5; ++i) {
    JointDesc j;
    j.type = kinds[i];
    j.a = link[std::size_t(i)];
    j.b = link[std::size_t(i) + 1];
    j.anchor_a = j.anchor_b = Vec3(Real(0.5) * Real(i) + Real(0.25), 0, 0);
    if (j.type == std::string("distance")) {
      j.anchor_a[0] -= Real(0.25);
      j.anchor_b[0] += Real(0.25);
      j.options.spring_hertz = 2;
      j.options.spring_damping = Real(0.1);
    }
    rigid.add_joint(j);
  }
  // two spheres held near the chain by ropes, so that collisions go on
  for (int i = 0; i < 2; ++i) {
    BodyDesc d = body_of(make_sphere(Real(0.2)), Vec3(Real(0.5 + 1.5 * i), Real(0.8), 0), 1, Real(0.4));
    d.restitution = Real(0.9);
    d.velocity = Vec3(0, Real(-1.5), Real(0.2));
    JointDesc j;
    j.type = "distance";
    j.a = link[std::size_t(1 + 3 * i)];
    j.b = rigid.add_body(d);
    j.anchor_a = s.position(j.a);
    j.anchor_b = s.position(j.b);
    j.options.has_limits = true;
    j.options.upper = Real(1.2);
    j.collide = true;
    rigid.add_joint(j);
  }
  const Momentum start = s.world().momentum();
  int contacts = 0;
  for (int k = 0; k < 10000; ++k) {
    s.world().step();
    contacts += !s.world().need<Collide>().contacts().active.empty();
  }
  const Momentum end = s.world().momentum();
  CHECK(contacts > 20);
  // scale: what the bodies carry between them, about 12 kg at 1 m/s and 1 m
  const double tolerance = sizeof(Real) == 8 ? 1e-9 : 2e-3;
  for (int i = 0; i < 3; ++i) {
    CAPTURE(i);
    CHECK(end.linear[i] == Approx(start.linear[i]).margin(12 * tolerance));
    CHECK(end.angular[i] == Approx(start.angular[i]).margin(closed_tolerance(solver).angular));
  }
}
