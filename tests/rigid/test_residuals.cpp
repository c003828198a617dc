// What world:residuals() says of bodies: each name made non-zero, and compared with what it must be.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

double residual(ClosedScene& s, const std::string& name) {
  for (const Residual& r : s.world().residuals())
    if (r.name == name) return r.value;
  FAIL("no residual " << name);
  return 0;
}

}  // namespace

TEST_CASE("rigid.joint_error_m is how far a joint is open", "[rigid][residuals]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  JointDesc j;
  j.type = "ball";
  j.b = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3::Zero()));
  s.rigid().add_joint(j);
  CHECK(residual(s, "rigid.joint_error_m") == 0);
  s.rigid().set_pose(j.b, {Vec3(Real(0.3), 0, Real(0.4)), Quat{}});
  CHECK(residual(s, "rigid.joint_error_m") == Approx(0.5));
}

TEST_CASE("rigid.sleeping counts bodies that sleep", "[rigid][residuals]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  CAPTURE(solver);
  ClosedScene s(solver);
  s.desc.sleeping = true;
  std::vector<ObjectId> boxes;
  for (int i = 0; i < 3; ++i) boxes.push_back(s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(Real(3 * i), 0, 0))));
  CHECK(residual(s, "rigid.sleeping") == 0);
  s.rigid().sleep(boxes[0]), s.rigid().sleep(boxes[2]);
  CHECK(residual(s, "rigid.sleeping") == 2);
  s.rigid().wake(boxes[0]);
  CHECK(residual(s, "rigid.sleeping") == 1);
}

// The first step at the iteration limit also raises a warning with its count.
TEST_CASE("rigid.capped counts iteration limits of the last step", "[rigid][residuals]") {
  ClosedScene s("impulse");
  s.desc.systems["rigid"].set("iterations", 1.0);
  s.rigid().add_body(ground_of(Real(0.5)));
  for (int i = 0; i < 8; ++i)
    s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(Real(0.02 * i), Real(0.49 + 0.98 * i), 0), 1, Real(0.5)));
  CHECK(residual(s, "rigid.capped") == 0);
  std::string said;
  for (int i = 0; i < 10 && said.empty(); ++i) {
    s.world().step();
    for (const Event& e : s.world().events().list())
      if (e.kind == EventKind::warning && s.world().events().warning_code(e) == "iteration_limit")
        said = std::string(s.world().events().warning_message(e));
  }
  REQUIRE(!said.empty());
  const double capped = residual(s, "rigid.capped");
  CHECK(capped > 0);
  CHECK_THAT(said, Catch::Contains(" " + std::to_string(static_cast<int>(capped)) + " times"));
}
