// Chains of joints held at both ends, that contacts touch and loads hang on: what joints and contacts do to each other.
// Directions that such a chain holds twice, and pushes that joints do not allow, must not become energy.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

struct Bridge {
  ClosedScene s;
  std::vector<ObjectId> planks, crates;
  double drop = 0;  // what falls, by how far, J

  // Planks of 1 m between two walls `slack` times nearer than they are long, in a V.
  Bridge(const char* solver, const char* type, int count, double slack, double thick, double mass, double wide = 3)
      : s(solver) {
    const double tilt = std::acos(slack), half = slack * count / 2;
    ObjectId last = post(-half);
    for (int i = 0; i < count; ++i) {
      const auto at = [&](double k) {
        return Vec3(Real(slack * k - half), Real(-std::sin(tilt) * (count / 2.0 - std::abs(k - count / 2.0))), 0);
      };
      BodyDesc d = body_of(make_box(1, Real(thick), Real(wide)), (at(i) + at(i + 1)) / 2, Real(mass), Real(0.6));
      d.rotation = from_axis_angle(Vec3(0, 0, 1), Real(i + 0.5 < count / 2.0   ? -tilt
                                                       : i + 0.5 > count / 2.0 ? tilt
                                                                               : 0));
      planks.push_back(s.rigid().add_body(d));
      join(type, last, planks.back(), at(i));
      last = planks.back();
      drop += mass * kG * count / 8;  // as a chain it sags deeper than the V
    }
    join(type, last, post(half), Vec3(Real(half), 0, 0));
  }
  void add_crate(double x, double y, double mass) {
    crates.push_back(s.rigid().add_body(
        body_of(make_box(Real(0.8), Real(0.8), Real(0.8)), Vec3(Real(x), Real(y), 0), Real(mass), Real(0.6))));
    drop += mass * kG * (y + double(planks.size()) / 4);
  }
  // A load on a ball below the joint in the middle.
  void hang(double mass) {
    const ObjectId plank = planks[planks.size() / 2];
    const Vec3 at = s.position(plank) - rotate(s.rotation(plank), Vec3(Real(0.5), 0, 0));
    const ObjectId load =
        s.rigid().add_body(body_of(make_box(Real(0.5), Real(0.5), Real(0.5)), at - Vec3(0, 1, 0), Real(mass)));
    join("ball", plank, load, at);
    drop += mass * kG * double(planks.size()) / 8;
  }
  double joint_error() {
    for (const Residual& r : s.world().residuals())
      if (std::string(r.name) == "rigid.joint_error_m") return r.value;
    return 1e9;
  }
  double energy() {
    const Energy e = s.world().energy();
    return e.kinetic + e.potential;
  }

 private:
  ObjectId post(double x) {
    BodyDesc d = body_of(make_box(1, 1, 1), Vec3(Real(x + (x < 0 ? -2 : 2)), 0, 0));
    d.type = BodyType::fixed;
    return s.rigid().add_body(d);
  }
  void join(const char* type, ObjectId a, ObjectId b, const Vec3& anchor) {
    JointDesc j;
    j.type = type;
    j.a = a, j.b = b;
    j.anchor_a = anchor;
    j.axis = Vec3(0, 0, 1);
    s.rigid().add_joint(j);
  }
};

}  // namespace

TEST_CASE("crates on bridges of hinged planks give them no energy", "[rigid][once][bridge][heavy]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const int planks = GENERATE(12, 20, 30, 40), crates = GENERATE(1, 3, 5, 8);
  if (solver != std::string("soft_step") && planks > 12) return;  // ten times slower
  if (kAsserts && (planks == 20 || planks == 30)) return;
  CAPTURE(solver, planks, crates);
  Bridge b(solver, "hinge", planks, 0.97, 0.2, 240);
  for (int i = 1; i <= crates; ++i) b.add_crate(i - crates / 2, 2 + i, 154);
  const double start = b.energy();
  double most = 0, open = 0;
  for (int i = 0; i < 480; ++i) {
    b.s.world().step();
    const double gain = (b.energy() - start) / b.drop;
    most = gain < 1e6 ? std::max(most, gain) : 1e6;
    open = std::max(open, b.joint_error());
  }
  CHECK(most < 0.02);
  CHECK(open < 0.05);
}

TEST_CASE("chains held at both ends carry loads of many times their links", "[rigid][once][bridge]") {
  const char* solver = solver_name(GENERATE(range(0, solver_count())));
  const char* type = GENERATE("hinge", "ball");
  const double slack = GENERATE(0.97, 0.999), ratio = GENERATE(1, 100, 10000);
  if (solver != std::string("soft_step") && ratio > 1000) return;  // beyond its limit: tests/README.md, Joints
  CAPTURE(solver, type, slack, ratio);
  Bridge b(solver, type, 10, slack, 0.2, 10, 1);
  b.hang(10 * ratio);
  const double start = b.energy();
  double most = 0, open = 0;
  for (int i = 0; i < 360; ++i) {
    b.s.world().step();
    const double gain = (b.energy() - start) / b.drop;
    most = gain < 1e6 ? std::max(most, gain) : 1e6;
    open = std::max(open, b.joint_error());
  }
  CHECK(most < 0.02);
  CHECK(open < (ratio > 1000 ? 0.02 : 0.0005));
}
