// Heavy loads on chains and bridges that meet other bodies, at default settings. The whole ranges are late tests.
#include <algorithm>

#include "rigid/closed_scene.h"

using namespace feder;

namespace {

struct Loaded {
  ClosedScene s{"soft_step"};
  double worst = 0, last = 0;      // m, that a joint is open
  double start = 0, most = 0;      // J
  std::vector<std::string> codes;  // of warnings

  ObjectId box(const Vec3& size, const Vec3& at, double mass) {
    BodyDesc d = body_of(make_box(size[0], size[1], size[2]), at, Real(mass), Real(0.6));
    if (mass == 0) d.type = BodyType::fixed;
    return s.rigid().add_body(d);
  }
  void join(ObjectId a, ObjectId b, const Vec3& at) {
    JointDesc j;
    j.type = "ball";
    j.a = a, j.b = b;
    j.anchor_a = at;
    s.rigid().add_joint(j);
  }
  bool says(const char* code) const { return std::find(codes.begin(), codes.end(), code) != codes.end(); }
  double energy() {
    const Energy e = s.world().energy();
    return e.kinetic + e.potential;
  }
  void run(double seconds) {
    start = most = energy();
    for (int step = 0; step < int(60 * seconds); ++step) {
      s.world().step();
      for (const Residual& r : s.world().residuals())
        if (std::string(r.name) == "rigid.joint_error_m") worst = std::max(worst, last = r.value);
      most = std::max(most, energy());
      for (const Event& e : s.world().events().list())
        if (e.kind == EventKind::warning) codes.push_back(s.world().events().warning_code(e));
    }
  }
};

// A ball of `ratio` kg on 12 links of 1 kg and 1 m, drawn aside by `degrees`, swings into a wall of 6 x 6 crates.
void wrecking_ball(Loaded& t, double ratio, double degrees) {
  t.s.rigid().add_body(ground_of(Real(0.6)));
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) t.box(Vec3(1, 1, 1), Vec3(3, Real(0.5 + row), Real(column - 2.5)), 10);
  const double angle = degrees * 3.14159265358979 / 180, c = std::cos(angle), s = std::sin(angle);
  const auto along = [&](double length) { return Vec3(Real(1 - length * s), Real(16 - length * c), 0); };
  ObjectId last = t.box(Vec3(Real(0.2), Real(0.2), Real(0.2)), along(0), 0);
  for (int k = 0; k <= 12; ++k) {
    BodyDesc d = body_of(k < 12 ? make_capsule(Real(0.1), Real(0.6)) : make_sphere(1), along(k < 12 ? k + 0.5 : 13),
                         Real(k < 12 ? 1 : ratio), Real(0.6));
    d.rotation = from_axis_angle(Vec3(0, 0, 1), Real(-angle));
    if (k < 12) d.mask = 0;
    const ObjectId body = t.s.rigid().add_body(d);
    t.join(last, body, along(k));
    last = body;
  }
}

}  // namespace

TEST_CASE("a wrecking ball stays on its chain", "[rigid][once][overload]") {
  const double ratio = GENERATE(100.0, 700.0, 1080.0, 5000.0), degrees = GENERATE(50.0, 85.0);
  CAPTURE(ratio, degrees);
  Loaded t;
  wrecking_ball(t, ratio, degrees);
  t.run(10);
  CAPTURE(t.worst, t.most - t.start);
  CHECK(t.worst < 0.05);
  CHECK(t.most - t.start < 0.01 * ratio * kG * 13);
}

// Links of 1 kg and half a metre lie in a zigzag, by `angle` from the horizontal; the load falls until they are taut.
TEST_CASE("a load that falls into its chain does not tear it", "[rigid][once][overload]") {
  const double angle = GENERATE(0.03, 0.1, 1.2);
  const double ratio = GENERATE(100.0, 500.0, 1000.0, 3000.0, 5000.0);
  const int links = GENERATE(10, 24);
  if (links > 10 && (angle > 1 || kAsserts)) return;
  CAPTURE(ratio, angle, links);
  Loaded t;
  ObjectId last = t.box(Vec3(Real(0.2), Real(0.2), Real(0.2)), Vec3(0, 0, 0), 0);
  Vec3 at(0, 0, 0);
  for (int k = 0; k < links; ++k) {
    const Vec3 step(Real((k % 2 ? -0.5 : 0.5) * std::cos(angle)), Real(-0.5 * std::sin(angle)), 0);
    const bool load = k == links - 1;
    BodyDesc d = body_of(load ? make_sphere(Real(0.5)) : make_capsule(Real(0.05), Real(0.3)), at + step / 2,
                         Real(load ? ratio : 1));
    if (load) d.position = at;
    d.mask = 0;
    const ObjectId body = t.s.rigid().add_body(d);
    t.join(last, body, at);
    last = body, at += step;
  }
  t.run(10);
  CAPTURE(t.worst, t.last, t.most - t.start);
  CHECK(t.worst < (links == 10 ? 0.15 : 0.5));
  CHECK((t.last < 0.03 || t.says("open_joint")));
  CHECK(t.most - t.start < 0.01 * ratio * kG * 0.5 * links);
}

// Planks of 10 kg on pairs of balls: loops, which get no pieces. The load stands on the middle.
TEST_CASE("a bridge holds, or says what it does not", "[rigid][overload]") {
  const double ratio = GENERATE(10.0, 26.0, 100.0, 3272.0);
  CAPTURE(ratio);
  Loaded t;
  ObjectId last = t.box(Vec3(1, 1, 2), Vec3(-6, 5, 0), 0);
  const ObjectId pier = t.box(Vec3(1, 1, 2), Vec3(6, 5, 0), 0);
  const auto join = [&](ObjectId a, ObjectId b, double x) {
    for (const double z : {-0.4, 0.4}) t.join(a, b, Vec3(Real(x), 5, Real(z)));
  };
  for (int k = 0; k < 20; ++k) {
    const double x = 0.5 * k - 4.75;
    const ObjectId plank = t.box(Vec3(Real(0.48), Real(0.1), 1), Vec3(Real(x), 5, 0), 10);
    join(last, plank, x - 0.25);
    last = plank;
  }
  join(last, pier, 5);
  t.box(Vec3(Real(0.8), Real(0.8), Real(0.8)), Vec3(0, Real(5.5), 0), 10 * ratio);
  t.run(10);
  CAPTURE(t.worst, t.last, t.most - t.start);
  CHECK((t.worst < 0.08 || t.says("open_joint")));
  CHECK((t.says("open_joint") || ratio < 100));
  CHECK(t.most - t.start < 1e-3 * 10 * ratio * kG);
}
