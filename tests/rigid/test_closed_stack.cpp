// Stacks against statics: what each level carries, what stays where it is, and that size does not matter.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

std::vector<ObjectId> add_stack(ClosedScene& s, int n, Real size, Real mass) {
  BodyDesc ground = body_of(make_box(40 * size, size, 40 * size), Vec3(0, -size / 2, 0), 0, Real(0.5));
  ground.type = BodyType::fixed;
  s.rigid().add_body(ground);
  std::vector<ObjectId> stack;
  for (int i = 0; i < n; ++i)
    stack.push_back(s.rigid().add_body(
        body_of(make_box(size, size, size), Vec3(0, size * (Real(i) + Real(0.5)), 0), mass, Real(0.5))));
  return stack;
}

// Sum of the normal impulses of the last step under a body: contacts below its centre.
double carried(ClosedScene& s, ObjectId body) {
  std::vector<Collide::ContactInfo> contacts;
  s.world().need<Collide>().contacts_of(body, contacts);
  double sum = 0;
  for (const auto& c : contacts)
    if (c.normal[1] < -Real(0.5)) sum += c.impulse;
  return sum;
}

}  // namespace

TEST_CASE("each level of a stack carries what is above it", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int n = GENERATE(1, 5, 10);
  CAPTURE(solver, n);
  ClosedScene s(solver);
  const std::vector<ObjectId> stack = add_stack(s, n, 1, 3);
  s.run(10);
  const double weight = 3 * kG * s.desc.dt;
  for (int i = 0; i < n; ++i) {
    CAPTURE(i);
    CHECK(carried(s, stack[std::size_t(i)]) ==
          Approx((n - i) * weight).epsilon(closed_tolerance(solver).stack_impulse));
    const Vec3 x = s.position(stack[std::size_t(i)]);
    const Real below = i ? s.position(stack[std::size_t(i) - 1])[1] : Real(-0.5);
    CHECK(x[1] - below == Approx(1).margin(closed_tolerance(solver).stack_drift));
    CHECK(std::abs(x[0]) + std::abs(x[2]) < Real(closed_tolerance(solver).stack_drift));
    CHECK(length(s.velocity(stack[std::size_t(i)])) < Real(0.01));
  }
}

// Nothing pushes a tower aside: what moves its boxes is the order in which corners are solved.
TEST_CASE("a tower of twenty keeps its place", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const bool on_plane = GENERATE(false, true);
  CAPTURE(solver, on_plane);
  ClosedScene s(solver);
  std::vector<ObjectId> tower;
  if (on_plane) {
    s.rigid().add_body(ground_of(Real(0.6)));
    for (int i = 0; i < 20; ++i)
      tower.push_back(s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(0, Real(i) + Real(0.5), 0), 500, Real(0.6))));
  } else {
    tower = add_stack(s, 20, 1, 1000);
  }
  Real worst = 0;
  for (int second = 0; second < 6; ++second) {
    s.run(1);
    for (const ObjectId body : tower) {
      const Vec3 x = s.position(body);
      worst = std::max(worst, length(Vec3(x[0], 0, x[2])));
    }
  }
  CHECK(worst < Real(1e-3));
}

// 20 mm of 20 m: what a contact yields, summed over the levels.
TEST_CASE("the top of a tower of twenty sinks by a thousandth of its height", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const bool turns = GENERATE(true, false);
  CAPTURE(solver, turns);
  ClosedScene s(solver);
  s.rigid().add_body(ground_of(Real(0.6)));
  std::vector<ObjectId> tower;
  for (int i = 0; i < 20; ++i) {
    BodyDesc crate = body_of(make_box(1, 1, 1), Vec3(0, Real(i) + Real(0.5), 0), 500, Real(0.6));
    if (!turns) crate.lock = std::uint8_t(kLockRx | kLockRy | kLockRz);
    tower.push_back(s.rigid().add_body(crate));
  }
  s.run(10);
  const double sink = 19.5 - double(s.position(tower.back())[1]);
  CHECK(sink < 0.02);
  CHECK(sink > -1e-4);
  for (const ObjectId body : tower) CHECK(length(s.velocity(body)) < Real(1e-3));
}

// One pass over the contacts per substep follows corners, which have lever and little inertia, only as far as they are
// soft: what it does not follow grows by a factor per second, most quickly in stacks of five.
TEST_CASE("stacks come to rest, few crates or many", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int n = GENERATE(2, 3, 4, 5, 6, 7, 8, 10, 12, 14);
  const bool flat = GENERATE(false, true);
  CAPTURE(solver, n, flat);
  ClosedScene s(solver);
  s.rigid().add_body(ground_of(Real(0.5)));
  const Real height = flat ? Real(0.25) : Real(1);
  std::vector<ObjectId> stack;
  for (int i = 0; i < n; ++i)
    stack.push_back(
        s.rigid().add_body(body_of(make_box(1, height, 1), Vec3(0, height * (Real(i) + Real(0.5)), 0), 3, Real(0.5))));
  s.run(8);
  for (const ObjectId body : stack) {
    CHECK(length(s.velocity(body)) < Real(1e-3));
    const Vec3 x = s.position(body);
    CHECK(length(Vec3(x[0], 0, x[2])) < Real(1.1e-4));
  }
}

// Each crate stands on two and carries two: twice the contacts of a tower act on one body.
TEST_CASE("a pyramid comes to rest", "[rigid][closed]") {
  ClosedScene s("soft_step");
  const int base = 20;
  s.rigid().add_body(ground_of(Real(0.6)));
  std::vector<ObjectId> crates;
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k)
      crates.push_back(s.rigid().add_body(
          body_of(make_box(1, 1, 1), Vec3((Real(k) - Real(base - 1 - row) / 2) * Real(1.1), Real(row) + Real(0.5), 0),
                  100, Real(0.6))));
  s.run(10);
  Real fastest = 0;
  for (const ObjectId body : crates) fastest = std::max(fastest, length(s.velocity(body)));
  CHECK(fastest < Real(2e-3));
  CHECK(s.position(crates.back())[1] == Approx(base - 0.5).margin(0.02));
}

// Boxes side by side sway together, by what one pass over the contacts leaves.
TEST_CASE("a large pyramid stops swaying", "[rigid][closed]") {
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3(0, -10, 0);
  const int base = 50;
  s.rigid().add_body(ground_of(Real(0.6)));
  std::vector<ObjectId> crates;
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k)
      crates.push_back(s.rigid().add_body(body_of(
          make_box(1, 1, 1), Vec3(Real(k) - Real(base - 1 - row) / 2, Real(row) + Real(0.5), 0), 100, Real(0.6))));
  s.run(200 / 60.0);
  Real sum = 0;
  for (const ObjectId body : crates) sum += length(s.velocity(body));
  CHECK(sum < Real(2.5e-3) * Real(crates.size()));
}

TEST_CASE("light under heavy", "[rigid][closed]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.rigid().add_body(ground_of(Real(0.5)));
  const ObjectId light = s.rigid().add_body(body_of(make_sphere(Real(0.5)), Vec3(0, Real(0.5), 0), 1, Real(0.5)));
  const ObjectId heavy = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(0, Real(1.5), 0), 100, Real(0.5)));
  // the unstable balance lasts this long
  s.run(0.5);
  CHECK(s.position(light)[1] == Approx(0.5).margin(0.01));
  CHECK(s.position(heavy)[1] == Approx(1.5).margin(closed_tolerance(solver).heavy_sink));
  CHECK(carried(s, light) == Approx(101 * kG * s.desc.dt).epsilon(0.1));
}
