// Every registered joint kind against the contract of constrain/joint.h. A new kind is enrolled by its line alone.
#include "base/rng.h"
#include "filled.h"
#include "support/catch.h"

using namespace feder;

namespace {

Real spread(Rng& rng, Real size) { return static_cast<Real>(rng.uniform(-1, 1)) * size; }
Vec3 random_vector(Rng& rng, Real size) {
  const Real x = spread(rng, size), y = spread(rng, size), z = spread(rng, size);
  return Vec3(x, y, z);
}
Quat turned(const Quat& q, const Vec3& by) { return integrate_rotation(q, by); }

// Options that switch on everything a kind understands.
JointOptions options_of(const JointKind& kind, bool everything) {
  JointOptions o;
  o.rest_length = Real(0.7);
  if (!everything) return o;
  o.has_limits = (kind.uses & kUsesLimits) != 0;
  o.lower = Real(-0.4);
  o.upper = Real(0.9);
  o.has_motor = (kind.uses & kUsesMotor) != 0;
  o.motor_speed = 2;
  o.motor_max = 5;
  if (kind.uses & kUsesSpring) o.spring_hertz = 3;
  return o;
}

struct Case {
  JointShape shape;
  JointInput in;
};

// A joint near its rest pose: frames meet up to `error` (m and rad).
void random_case(Rng& rng, Real error, Case& c) {
  c.shape.frame_a = {random_vector(rng, 1), turned({}, random_vector(rng, 3))};
  c.shape.frame_b = {random_vector(rng, 1), turned({}, random_vector(rng, 3))};
  c.in.joint = &c.shape;
  c.in.a = {random_vector(rng, 2), turned({}, random_vector(rng, 3))};
  c.in.index_a = 3;
  c.in.index_b = 5;
  const Pose frame = c.in.a * c.shape.frame_a;
  const Quat wanted = turned(frame.rotation, random_vector(rng, error));
  c.in.b.rotation = wanted * conjugate(c.shape.frame_b.rotation);
  c.in.b.position = frame.position + random_vector(rng, error) - rotate(c.in.b.rotation, c.shape.frame_b.position);
}

// The pose after a small motion with velocity v and angular velocity w for a time t.
Pose moved(const Pose& p, const Vec3& v, const Vec3& w, Real t) {
  return {p.position + t * v, integrate_rotation(p.rotation, t * w)};
}

const Real kStep = sizeof(Real) == 8 ? Real(1e-5) : Real(4e-3);
const Real kTolerance = sizeof(Real) == 8 ? Real(1e-8) : Real(6e-3);

}  // namespace

TEST_CASE("joint rows are the derivatives of their values", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const bool everything = GENERATE(false, true);
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name, everything);
  Rng rng(11);
  for (int trial = 0; trial < 200; ++trial) {
    Case c;
    random_case(rng, trial % 2 ? Real(0.02) : Real(0.8), c);
    // separate anchors of a line: near zero length its direction changes too fast for a difference quotient
    if (kind.uses & kUsesTwoAnchors) c.in.b.position += Vec3(2, -1, 1);
    c.shape.options = options_of(kind, everything);
    const Filled now(kind, c.in);
    const Vec3 va = random_vector(rng, 1), wa = random_vector(rng, 1);
    const Vec3 vb = random_vector(rng, 1), wb = random_vector(rng, 1);
    JointInput before = c.in, after = c.in;
    before.a = moved(c.in.a, va, wa, -kStep), after.a = moved(c.in.a, va, wa, kStep);
    before.b = moved(c.in.b, vb, wb, -kStep), after.b = moved(c.in.b, vb, wb, kStep);
    const Filled past(kind, before), next(kind, after);
    REQUIRE(past.rows.size() == now.rows.size());
    for (std::size_t i = 0; i < now.rows.size(); ++i) {
      const Row& r = now.rows[i];
      if (r.velocity_only) continue;
      CAPTURE(trial, i);
      const Real rate = dot(r.linear, vb - va) + dot(r.angular_a, wa) + dot(r.angular_b, wb);
      CHECK(rate == Approx((next.rows[i].value - past.rows[i].value) / (2 * kStep)).margin(kTolerance));
    }
  }
}

// bend is what is left of a difference over h when h dC/dt is taken away: right to the second order, however the mean
// of the angular velocity departs from its start.
TEST_CASE("stiff joint rows know how their values bend", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name);
  Rng rng(12);
  for (int trial = 0; trial < 200; ++trial) {
    Case c;
    random_case(rng, Real(1e-6), c);
    if (kind.uses & kUsesTwoAnchors) c.in.b.position += Vec3(2, -1, 1);
    c.shape.options = options_of(kind, false);
    JointInput now = c.in;
    now.h = Real(0.02);
    BodyMotion a, b;
    a.velocity = random_vector(rng, 3), b.velocity = random_vector(rng, 3);
    a.angular_velocity = random_vector(rng, 3), b.angular_velocity = random_vector(rng, 3);
    const Vec3 mean_a = a.angular_velocity + random_vector(rng, Real(0.1)),
               mean_b = b.angular_velocity + random_vector(rng, Real(0.1));
    a.bend = bend_matrix(a.angular_velocity, mean_a, now.h), b.bend = bend_matrix(b.angular_velocity, mean_b, now.h);
    now.motion_a = &a, now.motion_b = &b;
    JointInput after = now;
    after.a = moved(now.a, a.velocity, mean_a, now.h);
    after.b = moved(now.b, b.velocity, mean_b, now.h);
    const Filled rows(kind, now), next(kind, after);
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      const Row& r = rows.rows[i];
      if (r.linear.isZero(0)) {  // directions: left to the bias, see jointed_body.h
        CHECK(r.bend == 0);
        continue;
      }
      CAPTURE(trial, i);
      const Real rate = dot(r.linear, b.velocity - a.velocity) + dot(r.angular_a, a.angular_velocity) +
                        dot(r.angular_b, b.angular_velocity);
      // third order of angles up to 0.1: 0.1^3/6/h, and as much again from two bodies
      CHECK(r.bend == Approx((next.rows[i].value - r.value) / now.h - rate).margin(0.02));
    }
  }
}

TEST_CASE("joint row and block counts depend on the options only", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const bool everything = GENERATE(false, true);
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name, everything);
  Rng rng(3);
  std::size_t rows = 0, blocks = 0;
  for (int trial = 0; trial < 50; ++trial) {
    Case c;
    random_case(rng, trial % 3 ? Real(3) : Real(0), c);
    c.shape.options = options_of(kind, everything);
    const Filled f(kind, c.in);
    if (trial == 0) rows = f.rows.size(), blocks = f.blocks.size();
    REQUIRE(f.rows.size() == rows);
    REQUIRE(f.blocks.size() == blocks);
    REQUIRE(rows >= 1);
    REQUIRE(rows <= kMaxJointRows);
    std::uint32_t next = 0;
    for (const RowBlock& b : f.blocks) {
      CHECK(b.first == next);
      CHECK(b.first_impulse == next);
      CHECK(b.joint == 7);
      CHECK(b.index_a == 3);
      CHECK(b.index_b == 5);
      next += b.count;
      // a row with bounds stands alone
      for (std::uint32_t i = 0; b.count > 1 && i < b.count; ++i) {
        CHECK(f.rows[b.first + i].lower == -kInfinity);
        CHECK(f.rows[b.first + i].upper == kInfinity);
      }
    }
    CHECK(next == rows);
    for (const Row& r : f.rows) {
      CHECK(is_finite(r.linear));
      CHECK(is_finite(r.angular_a));
      CHECK(is_finite(r.angular_b));
      CHECK(is_finite(r.value));
    }
  }
}

// What a kind promises of its rows, whatever the options, is what it writes: solvers rely on it and do not call fill().
TEST_CASE("joint rows that solvers evaluate themselves are as promised", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const bool everything = GENERATE(false, true);
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name, everything);
  Rng rng(13);
  for (int trial = 0; trial < 50 && kind.wide == WideRows::point; ++trial) {
    Case c;
    random_case(rng, Real(0.5), c);
    c.shape.options = options_of(kind, everything);
    const Filled f(kind, c.in);
    REQUIRE(f.blocks.size() == 1);
    REQUIRE(f.rows.size() == 3);
    const Vec3 arm_a = rotate(c.in.a.rotation, c.shape.frame_a.position),
               arm_b = rotate(c.in.b.rotation, c.shape.frame_b.position);
    for (int k = 0; k < 3; ++k) {
      CAPTURE(trial, k);
      const Row& r = f.rows[static_cast<std::size_t>(k)];
      CHECK(length(Vec3(r.linear - Vec3(Vec3::Unit(k)))) == 0);
      CHECK(length(Vec3(r.angular_a + cross(arm_a, r.linear))) < Real(1e-5));
      CHECK(length(Vec3(r.angular_b - cross(arm_b, r.linear))) < Real(1e-5));
      CHECK(r.value == Approx(c.in.b.position[k] + arm_b[k] - c.in.a.position[k] - arm_a[k]).margin(1e-5));
      CHECK((r.lower == -kInfinity && r.upper == kInfinity && r.hertz == 0 && r.speed == 0 && !r.velocity_only));
    }
  }
}

// An impulse along a row gives -linear to a and +linear to b. Their moments about the origin cancel up to the couple
// gap x linear, which a row with an exact derivative cannot avoid while the anchors are apart.
TEST_CASE("joint impulses conserve momentum", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const Real error = GENERATE(Real(0), Real(0.05));
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name, error);
  Rng rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    Case c;
    random_case(rng, error, c);
    c.shape.options = options_of(kind, true);
    const Vec3 gap = to_world(c.in.b, c.shape.frame_b.position) - to_world(c.in.a, c.shape.frame_a.position);
    const Filled f(kind, c.in);
    for (const Row& r : f.rows) {
      const Vec3 moment =
          cross(c.in.b.position, r.linear) + r.angular_b - cross(c.in.a.position, r.linear) + r.angular_a;
      CHECK(length(moment) <= length(gap) * length(r.linear) + 40 * kEpsilon);
    }
  }
}

TEST_CASE("a joint at rest has no error and full rank", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name);
  Rng rng(8);
  for (int trial = 0; trial < 20; ++trial) {
    Case c;
    random_case(rng, 0, c);
    c.shape.options = options_of(kind, false);
    c.shape.options.rest_length = 0;
    const Filled f(kind, c.in);
    for (const Row& r : f.rows) {
      CHECK(std::abs(r.value) < 40 * kEpsilon);
      CHECK(length(r.linear) + length(r.angular_b) > Real(0.5));
    }
  }
}

// Side a is the world: identity pose, the frame is given in world coordinates.
TEST_CASE("joints hold to the world", "[constrain][contract]") {
  const int index = GENERATE(range(0, static_cast<int>(joint_kinds().size())));
  const JointKind& kind = joint_kinds()[static_cast<std::size_t>(index)];
  CAPTURE(kind.name);
  Rng rng(9);
  Case c;
  random_case(rng, 0, c);
  c.shape.options = options_of(kind, false);
  c.shape.options.rest_length = 0;
  // the same frame, once on body a, once on the world
  const Filled body(kind, c.in);
  JointShape world_shape = c.shape;
  world_shape.frame_a = c.in.a * c.shape.frame_a;
  JointInput in = c.in;
  in.joint = &world_shape;
  in.a = Pose{};
  in.index_a = 0;
  const Filled world(kind, in);
  REQUIRE(world.rows.size() == body.rows.size());
  for (std::size_t i = 0; i < body.rows.size(); ++i) {
    CHECK(length(world.rows[i].linear - body.rows[i].linear) < 40 * kEpsilon + Real(4e-6));
    CHECK(length(world.rows[i].angular_b - body.rows[i].angular_b) < 40 * kEpsilon + Real(4e-6));
    CHECK(world.rows[i].value == Approx(body.rows[i].value).margin(40 * kEpsilon));
  }
}
