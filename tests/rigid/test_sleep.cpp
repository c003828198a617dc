// Falling asleep and waking: what may sleep, when, and with which cause it wakes.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

struct SleepScene : ClosedScene {
  SleepScene() : ClosedScene("soft_step") {
    desc.sleeping = true;
    rigid().add_body(ground_of(Real(0.5)));
  }
  bool awake(ObjectId b) { return rigid().bodies().awake[rigid().index(b)] != 0; }
  ObjectId box(const Vec3& at) { return rigid().add_body(body_of(make_box(1, 1, 1), at, 1, Real(0.5))); }
  // Cause of the wake event of `b` in the last step.
  WakeCause cause(ObjectId b) {
    for (const Event& e : world().events().list())
      if (e.kind == EventKind::wake && e.a == b) return e.cause;
    return WakeCause::none;
  }
};

}  // namespace

TEST_CASE("a resting tower sleeps within two seconds, all at once, and says so", "[rigid][sleep]") {
  SleepScene s;
  std::vector<ObjectId> tower;
  for (int i = 0; i < 5; ++i) tower.push_back(s.box(Vec3(0, Real(0.5) + Real(i), 0)));
  int events = 0, asleep_at = -1;
  for (int step = 0; step < 120; ++step) {
    s.world().step();
    int sleepers = 0;
    for (const ObjectId b : tower) sleepers += !s.awake(b);
    REQUIRE((sleepers == 0 || sleepers == 5));
    for (const Event& e : s.world().events().list()) events += e.kind == EventKind::sleep;
    if (sleepers && asleep_at < 0) asleep_at = step;
  }
  CHECK(asleep_at > 20);  // not before about half a second of rest
  CHECK(events == 5);
  const Vec3 before = s.position(tower[4]);
  s.run(1);
  CHECK(length(s.position(tower[4]) - before) == 0);
}

TEST_CASE("a thrown body never sleeps in the air", "[rigid][sleep]") {
  const double speed = GENERATE(0.2, 0.5, 1.0, 3.0, 10.0);
  SleepScene s;
  s.world().set_gravity(Vec3(0, Real(-1.6), 0));
  BodyDesc d = body_of(make_sphere(Real(0.5)), Vec3(0, 30, 0));
  d.velocity = Vec3(0, static_cast<Real>(speed), 0);
  const ObjectId b = s.rigid().add_body(d);
  for (int i = 0; i < 240; ++i) {
    s.world().step();
    REQUIRE(s.awake(b));
  }
}

TEST_CASE("a slow roller never sleeps", "[rigid][sleep]") {
  SleepScene s;
  BodyDesc d = body_of(make_sphere(Real(0.5)), Vec3(0, Real(0.5), 0), 1, Real(0.8));
  d.velocity = Vec3(Real(0.12), 0, 0);
  d.angular_velocity = Vec3(0, 0, Real(-0.24));
  const ObjectId b = s.rigid().add_body(d);
  for (int i = 0; i < 300; ++i) {
    s.world().step();
    REQUIRE(s.awake(b));
  }
  CHECK(static_cast<double>(s.position(b)[0]) == Approx(0.6).epsilon(0.02));
}

TEST_CASE("sleepers wake by touch, and the cause is told", "[rigid][sleep]") {
  SleepScene s;
  std::vector<ObjectId> tower;
  for (int i = 0; i < 4; ++i) tower.push_back(s.box(Vec3(0, Real(0.5) + Real(i), 0)));
  s.run(2);
  REQUIRE(!s.awake(tower[0]));
  BodyDesc d = body_of(make_sphere(Real(0.3)), Vec3(-3, Real(3.5), 0), 1, Real(0.5));
  d.velocity = Vec3(8, 2, 0);
  const ObjectId ball = s.rigid().add_body(d);
  int steps = 0;
  while (!s.awake(tower[3]) && ++steps < 60) s.world().step();
  REQUIRE(steps < 60);
  CHECK(s.cause(tower[3]) == WakeCause::contact);
  CHECK(s.cause(tower[0]) == WakeCause::neighbor);
  bool by_ball = false;
  for (const Event& e : s.world().events().list())
    by_ball = by_ball || (e.kind == EventKind::wake && e.a == tower[3] && e.b == ball);
  CHECK(by_ball);
  for (const ObjectId b : tower) CHECK(s.awake(b));
}

TEST_CASE("scripts wake sleepers", "[rigid][sleep]") {
  const int how = GENERATE(range(0, 6));
  CAPTURE(how);
  SleepScene s;
  const ObjectId a = s.box(Vec3(0, Real(0.5), 0)), b = s.box(Vec3(0, Real(1.5), 0));
  s.run(2);
  REQUIRE(!s.awake(b));
  WakeCause expected = WakeCause::script;
  if (how == 0) s.rigid().wake(b);
  if (how == 1) s.rigid().set_velocity(b, Vec3(0, 1, 0));
  if (how == 2) s.rigid().apply_impulse(b, Vec3(0, 1, 0), nullptr), expected = WakeCause::force;
  if (how == 3) s.rigid().set_pose(a, Pose{Vec3(4, Real(0.5), 0), {}});
  if (how == 4) s.rigid().destroy_body(a, "test"), expected = WakeCause::destroyed;
  if (how == 5) {
    JointDesc j;
    j.type = "ball";
    j.a = b;
    j.anchor_a = Vec3(0, 3, 0);
    s.rigid().add_joint(j);
    expected = WakeCause::joint;
  }
  CHECK(s.awake(b));
  if (how != 4) CHECK(s.awake(a));
  s.world().step();
  CHECK(s.cause(b) == expected);
  if (how == 3 || how == 4) {
    s.run(1);
    CHECK(static_cast<double>(s.position(b)[1]) == Approx(0.5).margin(0.02));
  }
}

TEST_CASE("a body on a moving lift stays awake, on a resting one it sleeps", "[rigid][sleep]") {
  SleepScene s;
  BodyDesc d = body_of(make_box(4, 1, 4), Vec3(0, 2, 0), 1, Real(0.5));
  d.type = BodyType::kinematic;
  d.velocity = Vec3(0, Real(0.02), 0);
  const ObjectId lift = s.rigid().add_body(d);
  const ObjectId crate = s.box(Vec3(0, 3, 0));
  for (int i = 0; i < 240; ++i) {
    s.world().step();
    REQUIRE(s.awake(crate));
  }
  s.rigid().set_velocity(lift, Vec3::Zero());
  s.run(2);
  CHECK(!s.awake(crate));
  const Pose there = s.rigid().pose(lift);
  s.rigid().move_to(lift, Pose{there.position + Vec3(0, Real(0.01), 0), there.rotation});
  s.world().step();
  CHECK(s.awake(crate));
  CHECK(s.cause(crate) == WakeCause::contact);
}

TEST_CASE("bodies that must not sleep stay awake", "[rigid][sleep]") {
  SleepScene s;
  BodyDesc d = body_of(make_box(1, 1, 1), Vec3(0, Real(0.5), 0), 1, Real(0.5));
  d.can_sleep = false;
  const ObjectId restless = s.rigid().add_body(d);
  const ObjectId above = s.box(Vec3(0, Real(1.5), 0)), apart = s.box(Vec3(5, Real(0.5), 0));
  s.run(3);
  CHECK(s.awake(restless));
  CHECK(s.awake(above));  // the same island
  CHECK(!s.awake(apart));
}

// A face axis of a long box measures its far ends, 5 m away, so that an edge axis wins; the contact is a face all the
// same.
TEST_CASE("ten long thin rods across each other fall asleep", "[rigid][sleep]") {
  const double gap = GENERATE(0.03, 0.1);
  CAPTURE(gap);
  SleepScene s;
  std::vector<ObjectId> rods;
  for (int i = 0; i < 10; ++i) {
    BodyDesc d = body_of(make_box(10, Real(0.02), Real(0.02)),
                         Vec3(Real(0.1 * i), Real(0.02 + gap * i), Real(0.05 * i)), 4, Real(0.5));
    d.rotation = from_axis_angle(Vec3(0, 1, 0), Real((i % 2) * 1.5708 + 0.1 * i));
    rods.push_back(s.rigid().add_body(d));
  }
  s.run(5);
  for (const ObjectId b : rods) CHECK(!s.awake(b));
}
