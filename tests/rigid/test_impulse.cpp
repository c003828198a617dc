// The impulse solver on hand-made contacts: the closed forms of single impacts, worst-first order, penetration.
#include "rigid/impulse_heap.h"
#include "rigid/solver.h"
#include "state/colliders.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Bodies and contacts without collision detection: body i is collider i and solver slot i.
struct Bench {
  Arena arena{"test"};
  Colliders colliders{arena};
  Contacts contacts{arena};
  SolverBodies solver_bodies{arena};
  StepContext context;
  Params params;
  std::unique_ptr<RigidSolver> solver;
  Vec3 gravity = Vec3::Zero();
  std::vector<Vec3> positions;
  std::vector<Real> masses, inertias;

  explicit Bench(Real h = Real(1) / 240) {
    context.dt = context.h = h;
    solver_bodies.reset();
  }
  // mass 0: does not move
  std::uint32_t body(Real mass, Real inertia, const Vec3& position, const Vec3& velocity) {
    const std::uint32_t slot = solver_bodies.add(), collider = colliders.add();
    colliders.solver_slot[collider] = slot;
    SolverBody s;
    s.velocity = velocity;
    SolverMass m;
    if (mass > 0) {
      m.inv_mass = 1 / mass;
      m.inv_mass_axes = Vec3::Constant(1 / mass);
      m.inv_inertia = Mat3::Identity() / inertia;
    }
    m.center = position;
    solver_bodies.append(slot, s, m);
    masses.push_back(mass);
    inertias.push_back(inertia);
    return collider;
  }
  SolverBody& state(std::uint32_t body) { return solver_bodies.state[body + 1]; }
  Vec3 center(std::uint32_t body) { return solver_bodies.mass[body + 1].center + state(body).delta_position; }
  Contact& contact(std::uint32_t a, std::uint32_t b, const Vec3& normal) {
    Contact c;
    c.collider_a = a;
    c.collider_b = b;
    c.touching = 1;
    c.normal = normal;
    contacts.active.push_back(static_cast<std::uint32_t>(contacts.slots.size()));
    contacts.slots.push_back(c);
    return contacts.slots.back();
  }
  void point(Contact& c, const Vec3& at, Real separation) {
    ContactPoint& p = c.points[c.point_count++];
    p.arm_a = at - center(c.collider_a);
    p.arm_b = at - center(c.collider_b);
    p.separation = separation;
  }
  // One step of one substep.
  void step() {
    if (!solver) solver = find_variant(rigid_solvers(), "impulse", "rigid solver").make(arena, params);
    const SolverInput in{&contacts, &colliders, &solver_bodies, {}, {}, {}, {}, {}};
    for (std::size_t i = 1; i < solver_bodies.state.size(); ++i) {
      solver_bodies.mass[i].center += solver_bodies.state[i].delta_position;
      solver_bodies.mass[i].start_rotation = solver_bodies.state[i].rotation;
      solver_bodies.state[i].delta_position = solver_bodies.state[i].delta_rotation = Vec3::Zero();
    }
    solver->prepare(in, context);
    for (std::size_t i = 1; i < solver_bodies.state.size(); ++i)
      if (solver_bodies.mass[i].inv_mass > 0) solver_bodies.state[i].velocity += context.h * gravity;
    solver->solve(in, context);
    solver->finish(in, context);
  }
};

bool near(const Vec3& a, const Vec3& b, Real tolerance) { return length(a - b) <= tolerance; }

const Real kTight = 200 * kEpsilon;

}  // namespace

TEST_CASE("the heap gives the largest key, then the lowest index", "[rigid][impulse]") {
  Arena arena("test");
  WorstFirst heap(arena);
  heap.reserve(7);
  std::vector<Real> keys = {3, 9, 1, 9, 4, 0, 2};
  heap.build(0, 7, [&](std::uint32_t i) { return keys[i]; });
  std::vector<std::uint32_t> order;
  while (heap.top_key() >= 0) {
    order.push_back(heap.top());
    heap.update(heap.top(), -1);
  }
  CHECK(order == std::vector<std::uint32_t>{1, 3, 4, 0, 6, 2, 5});
}

TEST_CASE("head-on impact follows the formula of central impact", "[rigid][impulse]") {
  for (const double e : {0.0, 0.3, 0.8, 1.0}) {
    Bench bench;
    const Real m1 = 2, m2 = 5, v1 = 3, v2 = -1;
    const auto a = bench.body(m1, 1, Vec3(-1, 0, 0), Vec3(v1, 0, 0));
    const auto b = bench.body(m2, 1, Vec3(1, 0, 0), Vec3(v2, 0, 0));
    Contact& c = bench.contact(a, b, Vec3(1, 0, 0));
    c.restitution = static_cast<Real>(e);
    bench.point(c, Vec3::Zero(), 0);
    bench.step();
    CAPTURE(e);
    CHECK(bench.state(a).velocity[0] == Approx(((m1 - e * m2) * v1 + (1 + e) * m2 * v2) / (m1 + m2)).margin(kTight));
    CHECK(bench.state(b).velocity[0] == Approx(((m2 - e * m1) * v2 + (1 + e) * m1 * v1) / (m1 + m2)).margin(kTight));
    CHECK(bench.contacts.slots[0].points[0].total_impulse == Approx((1 + e) * m1 * m2 / (m1 + m2) * (v1 - v2)));
  }
}

TEST_CASE("corner impact with static and dynamic friction follows the closed form", "[rigid][impulse]") {
  const double e = 0.4, m = 2, inertia = 0.3;
  const Vec3 arm(Real(0.5), Real(-0.25), 0);
  for (const double mu : {0.0, 0.15, 10.0}) {
    CAPTURE(mu);
    Bench bench;
    const auto ground = bench.body(0, 0, Vec3(0, -1, 0), Vec3::Zero());
    const auto rod = bench.body(Real(m), Real(inertia), Vec3::Zero(), Vec3(1, -2, 0));
    Contact& c = bench.contact(ground, rod, Vec3(0, 1, 0));
    c.restitution = Real(e);
    c.friction_static = c.friction_dynamic = Real(mu);
    bench.point(c, arm, 0);
    bench.step();
    // K in the plane, then either the full stop or p (n + mu d)
    const double rx = arm[0], ry = arm[1];
    const double kxx = 1 / m + ry * ry / inertia, kyy = 1 / m + rx * rx / inertia, kxy = -rx * ry / inertia;
    double jx, jy;
    if (mu > 1) {
      const double dx = -1, dy = e * 2 + 2, det = kxx * kyy - kxy * kxy;
      jx = (kyy * dx - kxy * dy) / det;
      jy = (kxx * dy - kxy * dx) / det;
    } else {
      jy = (1 + e) * 2 / (kyy - mu * kxy);
      jx = -mu * jy;
    }
    const SolverBody& s = bench.state(rod);
    CHECK(near(s.velocity, Vec3(Real(1 + jx / m), Real(-2 + jy / m), 0), 20 * kTight));
    CHECK(s.angular_velocity[2] == Approx((rx * jy - ry * jx) / inertia).epsilon(40 * kTight));
  }
}

TEST_CASE("friction in space points against the slip", "[rigid][impulse]") {
  // a sphere: K is the same in all tangential directions, so the slip keeps its direction
  Bench bench;
  const auto ground = bench.body(0, 0, Vec3(0, -1, 0), Vec3::Zero());
  const auto ball = bench.body(1, Real(0.4), Vec3(0, 1, 0), Vec3(3, -1, 4));
  Contact& c = bench.contact(ground, ball, Vec3(0, 1, 0));
  c.friction_static = c.friction_dynamic = Real(0.5);
  bench.point(c, Vec3::Zero(), 0);
  bench.step();
  CHECK(near(bench.state(ball).velocity, Vec3(Real(3 - 0.3), 0, Real(4 - 0.4)), 20 * kTight));
}

TEST_CASE("a face that lands flat rises flat", "[rigid][impulse]") {
  Bench bench;
  const auto ground = bench.body(0, 0, Vec3(0, -1, 0), Vec3::Zero());
  const auto box = bench.body(1, Real(1) / 6, Vec3(0, Real(0.5), 0), Vec3(0, -2, 0));
  Contact& c = bench.contact(ground, box, Vec3(0, 1, 0));
  c.restitution = Real(0.5);
  for (const Real x : {Real(-0.5), Real(0.5)})
    for (const Real z : {Real(-0.5), Real(0.5)}) bench.point(c, Vec3(x, 0, z), 0);
  bench.step();
  CHECK(bench.state(box).velocity[1] == Approx(1).epsilon(1e-4));
  CHECK(length(bench.state(box).angular_velocity) < Real(1e-4));
}

// The impact is placed inside the substep, so the apexes do not depend on where steps end.
TEST_CASE("bounces reach e^2n of the drop height", "[rigid][impulse]") {
  for (const double e : {0.5, 0.8, 0.95, 1.0}) {
    CAPTURE(e);
    Bench bench(Real(1) / 240);
    bench.gravity = Vec3(0, Real(-9.81), 0);
    const auto ground = bench.body(0, 0, Vec3(0, -1, 0), Vec3::Zero());
    const auto ball = bench.body(1, Real(0.4), Vec3(0, 1, 0), Vec3::Zero());
    bench.contact(ground, ball, Vec3(0, 1, 0)).restitution = Real(e);
    bench.contacts.slots[0].point_count = 1;
    Real y_before = 1, y_now = 1;
    std::vector<double> apexes;
    for (int k = 0; k < 2400 && apexes.size() < 4; ++k) {
      ContactPoint& p = bench.contacts.slots[0].points[0];
      const Real y = bench.center(ball)[1];
      p.separation = y;
      p.arm_a = Vec3(0, 1, 0);
      p.arm_b = Vec3(0, -y, 0);
      p.normal_impulse = 0;
      bench.step();
      const Real y_next = bench.center(ball)[1];
      if (k > 2 && y_now > y_before && y_now >= y_next) {
        // top of the parabola through three positions
        const double d1 = (y_next - y_before) / 2.0, d2 = y_next - 2.0 * y_now + y_before;
        apexes.push_back(y_now - d1 * d1 / (2 * d2));
      }
      y_before = y_now;
      y_now = y_next;
    }
    REQUIRE(apexes.size() == 4);
    double expected = 1;
    // the drop starts at rest on a step, half a kick above the leapfrog's rest: h (1 + (g dt)^2 / 8 g h)
    const double start = 1 + 9.81 / (8 * 240.0 * 240.0);
    for (const double apex : apexes) {
      expected *= e * e;
      CHECK(apex == Approx(start * expected).epsilon(sizeof(Real) == 8 ? 1e-6 : 5e-3));
    }
  }
}

TEST_CASE("overlap is undone in proportion to inverse mass, without touching velocities", "[rigid][impulse]") {
  Bench bench;
  const auto a = bench.body(1, 1, Vec3(-1, 0, 0), Vec3::Zero());
  const auto b = bench.body(3, 1, Vec3(1, 0, 0), Vec3::Zero());
  Contact& c = bench.contact(a, b, Vec3(1, 0, 0));
  bench.point(c, Vec3::Zero(), Real(-0.1));
  bench.step();
  const Real depth = Real(0.1) - Real(0.0005);
  CHECK(bench.center(a)[0] == Approx(-1 - 0.75 * depth));
  CHECK(bench.center(b)[0] == Approx(1 + 0.25 * depth));
  CHECK(length(bench.state(a).velocity) == 0);
  CHECK(length(bench.state(b).velocity) == 0);
}

// One ball hits a row of three that touch: worst first carries the blow through, the last one leaves.
TEST_CASE("a blow travels through a row of equal balls", "[rigid][impulse]") {
  Bench bench;
  std::uint32_t ball[4];
  for (int i = 0; i < 4; ++i) ball[i] = bench.body(1, 1, Vec3(Real(i), 0, 0), Vec3(i == 0 ? Real(2) : Real(0), 0, 0));
  for (int i = 0; i < 3; ++i) {
    Contact& c = bench.contact(ball[i], ball[i + 1], Vec3(1, 0, 0));
    c.restitution = 1;
    bench.point(c, Vec3(Real(i) + Real(0.5), 0, 0), 0);
  }
  bench.step();
  for (int i = 0; i < 3; ++i) CHECK(bench.state(ball[i]).velocity[0] == Approx(0).margin(1e-4));
  CHECK(bench.state(ball[3]).velocity[0] == Approx(2).epsilon(1e-4));
}

TEST_CASE("an iteration limit that is reached is counted", "[rigid][impulse]") {
  Bench bench;
  bench.params.set("iterations", 1.0);
  std::uint32_t ball[8];
  for (int i = 0; i < 8; ++i) ball[i] = bench.body(1, 1, Vec3(Real(i), 0, 0), Vec3(i == 0 ? Real(8) : Real(0), 0, 0));
  for (int i = 0; i < 7; ++i) {
    Contact& c = bench.contact(ball[i], ball[i + 1], Vec3(1, 0, 0));
    bench.point(c, Vec3(Real(i) + Real(0.5), 0, 0), 0);
  }
  bench.step();
  CHECK(bench.solver->capped() > 0);
}
