// What is special about the soft step: kernels of different width give the same bits, overflow of colours, overlap
// is undone gently, chains under a heavy end hold, bounces of a stack gain no energy.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

// A heap with spheres and boxes, bouncing, rolling and sliding.
std::uint64_t heap_hash(const char* kernels) {
  ClosedScene s("soft_step");
  s.desc.systems["rigid"].set("kernels", std::string(kernels));
  s.rigid().add_body(ground_of(Real(0.5)));
  for (int i = 0; i < 60; ++i) {
    BodyDesc d =
        body_of(i % 3 ? make_box(1, Real(0.6), Real(0.8)) : make_sphere(Real(0.4)),
                Vec3(Real(i % 4) * Real(0.9), Real(0.7) + Real(i / 8) * Real(1.1), Real(i / 4 % 2) * Real(0.9)),
                1 + Real(i % 5), Real(0.5));
    d.restitution = i % 7 == 0 ? Real(0.5) : Real(0);
    d.rolling_friction = i % 3 ? Real(0) : Real(0.02);
    s.rigid().add_body(d);
  }
  for (int i = 0; i < 120; ++i) s.world().step();
  return s.world().hash();
}

}  // namespace

TEST_CASE("soft step: plain and wide kernels give the same bits", "[rigid][soft_step]") {
  CHECK(heap_hash("plain") == heap_hash("auto"));
}

TEST_CASE("soft step: more contacts on a body than there are colours", "[rigid][soft_step]") {
  ClosedScene s("soft_step");
  s.rigid().add_body(ground_of(Real(0.5)));
  const ObjectId plate = s.rigid().add_body(body_of(make_box(40, 1, 40), Vec3(0, Real(0.5), 0), 1000, Real(0.5)));
  std::vector<ObjectId> crates;
  for (int i = 0; i < 100; ++i)
    crates.push_back(s.rigid().add_body(
        body_of(make_box(1, 1, 1), Vec3(Real(i % 10) * 3 - 14, Real(1.5), Real(i / 10) * 3 - 14), 5, Real(0.5))));
  s.run(2);
  CHECK(static_cast<double>(s.position(plate)[1]) == Approx(0.5).margin(0.01));
  for (const ObjectId c : crates) REQUIRE(static_cast<double>(s.position(c)[1]) == Approx(1.5).margin(0.02));
}

TEST_CASE("soft step: overlap of two contacts ends no faster than both push", "[rigid][soft_step]") {
  ClosedScene s("soft_step");
  s.rigid().add_body(ground_of(Real(0.5)));
  const ObjectId a = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(0, Real(0.3), 0), 1, Real(0.5)));
  const ObjectId b = s.rigid().add_body(body_of(make_box(1, 1, 1), Vec3(0, Real(1.05), 0), 1, Real(0.5)));
  double fastest = 0, highest = 0;
  for (int i = 0; i < 120; ++i) {
    s.world().step();
    fastest = std::max({fastest, static_cast<double>(s.velocity(a)[1]), static_cast<double>(s.velocity(b)[1])});
    highest = std::max(highest, static_cast<double>(s.position(b)[1]));
  }
  CHECK(fastest < 6);  // push_speed 3 m/s each
  CHECK(highest < 2);
  CHECK(static_cast<double>(s.position(a)[1]) == Approx(0.5).margin(0.01));
  CHECK(static_cast<double>(s.position(b)[1]) == Approx(1.5).margin(0.01));
}

TEST_CASE("soft step: a light chain holds a heavy ball", "[rigid][soft_step]") {
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3(0, -10, 0);
  ObjectId last;
  Vec3 at = Vec3::Zero();
  for (int k = 0; k < 20; ++k) {
    const bool heavy = k == 19;
    BodyDesc d = body_of(make_sphere(heavy ? Real(2) : Real(0.25)),
                         Vec3(Real(0.5) * Real(k) + (heavy ? Real(1.75) : Real(0)), 0, 0), 0);
    d.mass = 0, d.density = 1000, d.mask = 0;
    if (k == 0) d.type = BodyType::fixed;
    const ObjectId id = s.rigid().add_body(d);
    if (k) {
      JointDesc j;
      j.type = "ball";
      j.a = last, j.b = id;
      j.anchor_a = at + Vec3(Real(0.25), 0, 0);
      s.rigid().add_joint(j);
    }
    last = id;
    at = d.position;
  }
  Real worst = 0;
  for (int i = 0; i < 600; ++i) {
    s.world().step();
    worst = std::max(worst, s.rigid().max_joint_error());
  }
  CHECK(static_cast<double>(worst) < 0.05);
}

TEST_CASE("soft step: balls that bounce in a stack gain no energy", "[rigid][soft_step]") {
  const double e = GENERATE(0.3, 0.5, 0.8);
  CAPTURE(e);
  ClosedScene s("soft_step");
  BodyDesc ground = ground_of(0);
  s.rigid().add_body(ground);
  for (int i = 0; i < 4; ++i) {
    BodyDesc d = body_of(make_sphere(Real(0.5)), Vec3(0, 3 + Real(1.05) * Real(i), 0));
    d.restitution = static_cast<Real>(e);
    s.rigid().add_body(d);
  }
  const auto total = [&] {
    const Energy x = s.world().energy();
    return x.kinetic + x.potential;
  };
  const double start = total();
  double most = 0;
  for (int i = 0; i < 240; ++i) {
    s.world().step();
    most = std::max(most, total());
  }
  CHECK(most < 1.02 * start);
}
