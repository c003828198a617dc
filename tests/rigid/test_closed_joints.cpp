// Joints against closed forms: pendulum, spring, motor, limits, breaking loads, a chain that hangs.
#include "rigid/closed_scene.h"

using namespace feder;

// A rod about its end: T = 2 pi sqrt(I / m g d) (2/pi) K(sin^2(a/2)); 1.637946586 s for a thin rod of 1 m.
TEST_CASE("compound pendulum on a hinge", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const double degrees = GENERATE(5.0, 60.0);
  CAPTURE(solver, degrees);
  ClosedScene s(solver);
  const double start = degrees * 3.14159265358979 / 180, thick = 0.02;
  BodyDesc d = body_of(make_box(Real(thick), 1, Real(thick)), Vec3::Zero(), 2);
  d.rotation = from_axis_angle(Vec3(0, 0, 1), Real(start));
  d.position = rotate(d.rotation, Vec3(0, Real(-0.5), 0));
  const ObjectId rod = s.rigid().add_body(d);
  JointDesc j;
  j.type = "hinge";
  j.a = rod;
  s.rigid().add_joint(j);
  const double inertia = (1 + thick * thick) / 12 + 0.25;  // per mass, about the end
  const double small = 2 * 3.14159265358979323846 * std::sqrt(inertia / (kG * 0.5));
  CHECK(small == Approx(1.637946586).epsilon(1e-3));
  const double half = std::sin(start / 2), period = small * 2 / 3.14159265358979323846 * elliptic_k(half * half);
  // times at which the rod passes the middle in one direction
  std::vector<double> passes;
  double before = 1, worst = 0, top = 0;
  for (int i = 1; i <= 60 * 10; ++i) {
    s.world().step();
    const double x = s.position(rod)[0];
    if (before < 0 && x >= 0) passes.push_back((i - 1 + before / (before - x)) / 60.0);
    before = x;
    worst = std::max(worst, std::abs(double(length(s.position(rod))) - 0.5));
    if (i > 60 * 8) top = std::max(top, std::abs(x));
  }
  REQUIRE(passes.size() >= 3);
  const double measured = (passes.back() - passes.front()) / double(passes.size() - 1);
  CHECK(measured == Approx(period).epsilon(closed_tolerance(solver).pendulum));
  CHECK(worst < closed_tolerance(solver).joint_error);
  CHECK(top == Approx(0.5 * std::sin(start)).epsilon(0.03));  // swings as far as at the start
  CHECK(s.rigid().max_joint_error() < closed_tolerance(solver).joint_error);
}

// v <- (v - h (k/m) x) / (1 + h c/m + h^2 k/m), x <- x + h v: a spring of 2 Hz and damping ratio 0.1.
TEST_CASE("a damped spring follows the implicit recurrence", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver, 1.0 / 60, 1);
  s.desc.gravity = Vec3::Zero();
  const ObjectId ball = s.rigid().add_body(body_of(make_sphere(Real(0.2)), Vec3(3, 0, 0), 5));
  JointDesc j;
  j.type = "distance";
  j.b = ball;
  j.anchor_b = Vec3(3, 0, 0);
  j.options.rest_length = 2;
  j.options.spring_hertz = 2;
  j.options.spring_damping = Real(0.1);
  s.rigid().add_joint(j);
  const double h = 1.0 / 60, omega = 2 * 3.14159265358979323846 * 2, k = omega * omega, c = 2 * 0.1 * omega;
  double x = 1, v = 0, worst = 0;
  for (int i = 0; i < 120; ++i) {
    v = (v - h * k * x) / (1 + h * c + h * h * k);
    x += h * v;
    s.world().step();
    worst = std::max({worst, std::abs(s.position(ball)[0] - 2 - x), std::abs(double(s.velocity(ball)[0]) - v)});
  }
  CHECK(x == Approx(0.0034582).margin(1e-6));
  CHECK(v == Approx(0.0748495).margin(1e-6));
  CHECK(worst < closed_tolerance(solver).spring);
}

TEST_CASE("a motor with a largest torque", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.desc.gravity = Vec3::Zero();
  const ObjectId wheel = s.rigid().add_body(body_of(make_box(1, 1, Real(0.2)), Vec3(0, 2, 0), 6));
  const double inertia = 6.0 * 2 / 12, torque = 3, target = 5;
  JointDesc j;
  j.type = "hinge";
  j.b = wheel;
  j.anchor_a = Vec3(0, 2, 0);
  j.options.has_motor = true;
  j.options.motor_speed = Real(target);
  j.options.motor_max = Real(torque);
  const ObjectId joint = s.rigid().add_joint(j);
  s.run(1);
  CHECK(s.spin(wheel)[2] == Approx(torque / inertia).epsilon(1e-3));
  CHECK(length(s.rigid().joint_torque(joint)) == Approx(torque).epsilon(1e-3));
  s.run(1);
  CHECK(s.spin(wheel)[2] == Approx(target).epsilon(1e-3));
  CHECK(length(s.rigid().joint_torque(joint)) < Real(0.01));
}

TEST_CASE("hinge limits stop the swing", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  // a level arm falls from angle 0 to its lower limit
  const ObjectId arm = s.rigid().add_body(body_of(make_box(1, Real(0.1), Real(0.1)), Vec3(Real(0.5), 0, 0), 2));
  JointDesc j;
  j.type = "hinge";
  j.b = arm;
  j.options.has_limits = true;
  j.options.lower = Real(-0.6);
  j.options.upper = Real(0.2);
  const ObjectId joint = s.rigid().add_joint(j);
  double lowest = 0;
  for (int i = 0; i < 180; ++i) {
    s.world().step();
    lowest = std::min(lowest, double(s.rigid().joint_coordinate(joint)));
  }
  CHECK(lowest > -0.62);
  CHECK(s.rigid().joint_coordinate(joint) == Approx(-0.6).margin(2e-3));
  CHECK(length(s.spin(arm)) < Real(1e-3));
  // the limit carries the moment m g d cos(0.6)
  CHECK(std::abs(s.rigid().joint_torque(joint)[2]) == Approx(2 * kG * 0.5 * std::cos(0.6)).epsilon(0.01));
}

// The tension above link k is the weight of all below.
TEST_CASE("a chain that hangs", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  const int n = 6;
  ObjectId above;
  std::vector<ObjectId> joints;
  for (int i = 0; i < n; ++i) {
    BodyDesc d = body_of(make_box(Real(0.1), Real(0.4), Real(0.1)), Vec3(0, Real(-0.25 - 0.5 * i), 0), 2);
    d.linear_damping = d.angular_damping = Real(0.5);
    const ObjectId link = s.rigid().add_body(d);
    JointDesc j;
    j.type = "ball";
    j.a = above;
    j.b = link;
    j.anchor_a = Vec3(0, Real(-0.5 * i), 0);
    joints.push_back(s.rigid().add_joint(j));
    above = link;
  }
  s.run(4);
  for (int i = 0; i < n; ++i) {
    CAPTURE(i);
    CHECK(length(s.rigid().joint_force(joints[std::size_t(i)])) == Approx((n - i) * 2 * kG).epsilon(0.01));
  }
  CHECK(s.rigid().max_joint_error() < closed_tolerance(solver).joint_error);
}

// A ball hits the bob of a pendulum along its rod: the joint takes the momentum within one substep of the step,
// whichever it is, and breaks if that force is above its limit. It would not by what it bears in the last substep.
TEST_CASE("a joint breaks by a blow in any substep", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int delay = GENERATE(range(0, 4));
  CAPTURE(solver, delay);
  for (const bool breaks : {false, true}) {
    ClosedScene s(solver);
    s.desc.gravity = Vec3::Zero();
    const ObjectId bob = s.rigid().add_body(body_of(make_sphere(Real(0.5)), Vec3::Zero(), 2));
    JointDesc j;
    j.type = "ball";
    j.b = bob;
    j.anchor_a = Vec3(0, 1, 0);
    // 1 kg at 5 m/s stops within a substep or two: between 600 and 1300 N
    const Real blow = 5 / static_cast<Real>(s.h());
    j.break_force = breaks ? blow / 4 : blow * 3;
    s.rigid().add_joint(j);
    // it arrives in the substep number `delay` of the third step
    const Real flight = Real(5) * static_cast<Real>(s.h()) * (Real(8.5) + Real(delay));
    BodyDesc ball = body_of(make_sphere(Real(0.25)), Vec3(0, Real(-0.75) - flight, 0), 1);
    ball.velocity = Vec3(0, 5, 0);
    s.rigid().add_body(ball);
    s.run(0.2);
    CHECK(s.rigid().joint_count() == (breaks ? 0u : 1u));
  }
}

TEST_CASE("a joint breaks above its load, not below", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  for (const double load : {0.98, 1.02}) {
    ClosedScene s(solver);
    const ObjectId box = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3::Zero(), Real(load * 10)));
    JointDesc j;
    j.type = "ball";
    j.b = box;
    j.break_force = Real(10 * kG);
    s.rigid().add_joint(j);
    s.run(1);
    CAPTURE(load);
    CHECK(s.rigid().joint_count() == (load < 1 ? 1u : 0u));
  }
}
