// Point joints in loops, which are solved eight at a time: same bits however they are run, no joint lost to a lane or a
// colour, and forces as statics demands.
#include "rigid/closed_scene.h"

using namespace feder;

namespace {

// A net of balls and cubes, tied to their neighbours and by two corners to the world, falls on the ground. Some of it
// are long boxes, whose joints go by rows, and a chain beside it is a tree.
std::vector<ObjectId> hang_net(ClosedScene& s, int side, bool only_balls = false) {
  s.rigid().add_body(ground_of(Real(0.5)));
  std::vector<ObjectId> net;
  const auto join = [&](ObjectId a, ObjectId b, const Vec3& at) {
    JointDesc j;
    j.type = "ball";
    j.a = a, j.b = b;
    j.anchor_a = at;
    s.rigid().add_joint(j);
  };
  for (int i = 0; i < side; ++i) {
    for (int k = 0; k < side; ++k) {
      const Vec3 at(Real(0.5) * Real(i), Real(1), Real(0.5) * Real(k));
      const ShapePtr shape = only_balls || (i + k) % 3 ? make_sphere(Real(0.2))
                             : (i + k) % 2             ? make_box(Real(0.3), Real(0.3), Real(0.3))
                                                       : make_box(Real(0.3), Real(0.1), Real(0.2));
      BodyDesc d = body_of(shape, at, Real(1 + (i * k) % 3), Real(0.5));
      d.velocity = Vec3(Real(0.1) * Real(k), 0, Real(-0.05) * Real(i));
      net.push_back(s.rigid().add_body(d));
      const std::size_t here = net.size() - 1;
      if (k > 0) join(net[here - 1], net[here], at - Vec3(0, 0, Real(0.25)));
      if (i > 0) join(net[here - static_cast<std::size_t>(side)], net[here], at - Vec3(Real(0.25), 0, 0));
    }
  }
  join(net.front(), {}, Vec3(0, Real(1.3), 0));
  join(net.back(), {}, Vec3(Real(0.5) * Real(side - 1), Real(1.3), Real(0.5) * Real(side - 1)));
  return net;
}

std::uint64_t hash_of_net(int threads, const char* kernels) {
  ClosedScene s("soft_step");
  s.desc.threads = threads;
  s.desc.systems["rigid"].set("kernels", std::string(kernels));
  hang_net(s, 15);
  for (int i = 0; i < 90; ++i) s.world().step();
  REQUIRE(s.world().is_finite());
  return s.world().hash();
}

}  // namespace

TEST_CASE("wide joints: the same bits for threads and kernels", "[rigid][joints][threads]") {
  const std::uint64_t one = hash_of_net(1, "auto");
  CHECK(hash_of_net(2, "auto") == one);
  CHECK(hash_of_net(4, "auto") == one);
  CHECK(hash_of_net(1, "plain") == one);
  CHECK(hash_of_net(4, "plain") == one);
}

// The order of a solve is a function of the state: a restored world, in which nothing was kept, goes on alike.
TEST_CASE("wide joints: a restored world goes on with the same bits", "[rigid][joints]") {
  ClosedScene s("soft_step"), other("soft_step");
  const std::vector<ObjectId> net = hang_net(s, 8), same = hang_net(other, 8);
  for (int i = 0; i < 60; ++i) {
    if (i == 20) s.rigid().destroy_body(net[27], "test");
    if (i % 10 == 0) s.world().restore(s.world().snapshot());
    s.world().step();
    if (i == 20) other.rigid().destroy_body(same[27], "test");
    other.world().step();
    REQUIRE(s.world().hash() == other.world().hash());
  }
}

// Two wheels on a common hub: rings of even bodies, each tied to the hub twice. It has more joints than there are
// colours; those that find none are solved by rows.
TEST_CASE("wide joints: a hub with more joints than colours holds them all", "[rigid][joints]") {
  ClosedScene s("soft_step");
  s.desc.gravity = Vec3::Zero();
  const ObjectId hub = s.rigid().add_body(body_of(make_sphere(1), Vec3::Zero(), 50));
  const int count = 80;
  for (int i = 0; i < count; ++i) {
    Real sn, cs;
    sin_cos(2 * kPi * Real(i) / Real(count), sn, cs);
    BodyDesc d = body_of(make_sphere(Real(0.05)), Vec3(2 * cs, 2 * sn, 0), Real(0.1));
    d.velocity = Vec3(-2 * sn, 2 * cs, 0);
    const ObjectId ball = s.rigid().add_body(d);
    for (const Real z : {Real(-0.2), Real(0.2)}) {
      JointDesc j;
      j.type = "ball";
      j.a = hub, j.b = ball;
      j.anchor_a = Vec3(Real(1.5) * cs, Real(1.5) * sn, z);
      s.rigid().add_joint(j);
    }
  }
  const Momentum before = s.world().momentum();
  double worst = 0;
  for (int i = 0; i < 120; ++i) {
    s.world().step();
    worst = std::fmax(worst, static_cast<double>(s.rigid().max_joint_error()));
  }
  CHECK(worst < 0.01);
  const Momentum after = s.world().momentum();
  CHECK(after.angular[2] == Approx(before.angular[2]).epsilon(0.01));
}

// A ring of balls hangs on one joint: it carries their weight, also far from the origin.
TEST_CASE("wide joints: the force on a ring at rest is its weight", "[rigid][joints]") {
  const Real far = GENERATE(Real(0), Real(3000));
  CAPTURE(far);
  ClosedScene s("soft_step");
  std::vector<ObjectId> ring;
  const int count = 6;
  for (int i = 0; i < count; ++i) {
    Real sn, cs;
    sin_cos(2 * kPi * Real(i) / Real(count), sn, cs);
    BodyDesc d = body_of(make_sphere(Real(0.2)), Vec3(far + sn, cs, 0), 2);
    d.linear_damping = d.angular_damping = 3;
    ring.push_back(s.rigid().add_body(d));
  }
  JointDesc j;
  j.type = "ball";
  for (std::size_t i = 0; i < ring.size(); ++i) {
    j.a = ring[i], j.b = ring[(i + 1) % ring.size()];
    j.anchor_a = (s.position(j.a) + s.position(j.b)) / 2;
    s.rigid().add_joint(j);
  }
  j.a = ring[0], j.b = {};
  j.anchor_a = s.position(ring[0]) + Vec3(0, Real(0.2), 0);
  const ObjectId top = s.rigid().add_joint(j);
  s.run(6);
  // damping is implicit, so that a kick by gravity is damped too
  const double kick = kG / (1 + 3 * s.h());
  CHECK(std::fabs(static_cast<double>(s.rigid().joint_force(top)[1])) == Approx(count * 2 * kick).epsilon(1e-3));
  // stretched by its own weight, as by rows, and no more far away; a position has a grain of 0.24 mm there
  CHECK(static_cast<double>(s.rigid().max_joint_error()) < 0.004);
}
