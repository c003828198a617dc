// Closed forms of single joint kinds: coordinates, limits, motors, springs.
#include "filled.h"
#include "support/catch.h"

using namespace feder;

namespace {

const JointKind& kind_of(const char* name) { return find_variant(joint_kinds(), name, "joint"); }

// Two bodies whose frames' x axes are the world's z, b rotated by `angle` about it.
JointInput hinge_at(JointShape& shape, Real angle) {
  const Quat axis = rotation_from_to(Vec3(1, 0, 0), Vec3(0, 0, 1));
  shape.frame_a = {Vec3(1, 0, 0), axis};
  shape.frame_b = {Vec3(-1, 0, 0), axis};
  JointInput in;
  in.joint = &shape;
  in.b.rotation = from_axis_angle(Vec3(0, 0, 1), angle);
  in.b.position = Vec3(1, 0, 0) - rotate(in.b.rotation, shape.frame_b.position);
  return in;
}

}  // namespace

TEST_CASE("hinge angle is the turn of b against a", "[constrain]") {
  for (const double angle : {-3.1, -1.5707963267948966, -0.3, 0.0, 1e-4, 0.7, 2.0, 3.1}) {
    JointShape shape;
    const JointInput in = hinge_at(shape, static_cast<Real>(angle));
    CHECK(kind_of("hinge").coordinate(in) == Approx(angle).margin(8 * kEpsilon));
  }
}

TEST_CASE("hinge limits give the room that is left, anywhere on the circle", "[constrain]") {
  JointShape shape;
  shape.options.has_limits = true;
  const auto rooms = [&](Real angle, Real lower, Real upper) {
    shape.options.lower = lower;
    shape.options.upper = upper;
    const JointInput in = hinge_at(shape, angle);
    const Filled f(kind_of("hinge"), in);
    REQUIRE(f.rows.size() == 7);
    for (int k = 5; k < 7; ++k) CHECK((f.rows[k].lower == 0 && f.rows[k].upper == kInfinity));
    // turning forward uses up the upper room
    CHECK(dot(f.rows[5].angular_b, Vec3(0, 0, 1)) == Approx(1));
    CHECK(dot(f.rows[6].angular_b, Vec3(0, 0, 1)) == Approx(-1));
    return std::pair<Real, Real>(f.rows[5].value, f.rows[6].value);
  };
  const Real margin = 16 * kEpsilon;
  CHECK(rooms(Real(0.2), Real(-0.5), 1).first == Approx(0.7).margin(margin));
  CHECK(rooms(Real(0.2), Real(-0.5), 1).second == Approx(0.8).margin(margin));
  CHECK(rooms(Real(1.2), Real(-0.5), 1).second == Approx(-0.2).margin(margin));
  // limits across the jump at pi: 2.5 .. 4 holds the angle -2.5 = 3.783
  CHECK(rooms(Real(-2.5), Real(2.5), 4).first == Approx(2 * 3.14159265358979 - 5).margin(margin));
  CHECK(rooms(Real(-2.5), Real(2.5), 4).second == Approx(4 - (2 * 3.14159265358979 - 2.5)).margin(margin));
}

TEST_CASE("hinge motor asks for a speed within its torque", "[constrain]") {
  JointShape shape;
  shape.options.has_motor = true;
  shape.options.motor_speed = 3;
  shape.options.motor_max = 7;
  const Filled f(kind_of("hinge"), hinge_at(shape, Real(0.4)));
  REQUIRE(f.rows.size() == 6);
  const Row& motor = f.rows[5];
  CHECK(motor.velocity_only);
  CHECK(motor.speed == 3);
  CHECK(motor.lower == -7);
  CHECK(motor.upper == 7);
  CHECK(length(motor.angular_b - Vec3(0, 0, 1)) < 8 * kEpsilon);
  CHECK(length(motor.angular_a + Vec3(0, 0, 1)) < 8 * kEpsilon);
}

TEST_CASE("distance is the length between the anchors, and limits bound it", "[constrain]") {
  JointShape shape;
  shape.frame_a.position = Vec3(0, 1, 0);
  shape.frame_b.position = Vec3(0, -1, 0);
  shape.options.rest_length = 4;
  JointInput in;
  in.joint = &shape;
  in.b.position = Vec3(3, 6, 0);  // anchors (0,1,0) and (3,5,0)
  const JointKind& kind = kind_of("distance");
  CHECK(kind.coordinate(in) == Approx(5));
  {
    const Filled f(kind, in);
    REQUIRE(f.rows.size() == 1);
    CHECK(f.rows[0].value == Approx(1));
    CHECK(length(f.rows[0].linear - Vec3(Real(0.6), Real(0.8), 0)) < 8 * kEpsilon);
  }
  shape.options.has_limits = true;
  shape.options.lower = 2;
  shape.options.upper = Real(4.5);
  {
    const Filled f(kind, in);  // a rope: no rest length
    REQUIRE(f.rows.size() == 2);
    CHECK(f.rows[0].value == Approx(3));
    CHECK(f.rows[1].value == Approx(-0.5));
    CHECK(dot(f.rows[1].linear, Vec3(Real(0.6), Real(0.8), 0)) == Approx(-1));
  }
  shape.options.spring_hertz = 2;
  shape.options.spring_damping = Real(0.1);
  {
    const Filled f(kind, in);
    REQUIRE(f.rows.size() == 3);
    CHECK(f.rows[0].hertz == 2);
    CHECK(f.rows[0].damping_ratio == Real(0.1));
  }
}

TEST_CASE("weld measures the rotation vector in the axes of a", "[constrain]") {
  JointShape shape;
  JointInput in;
  in.joint = &shape;
  in.a.rotation = from_axis_angle(Vec3(1, 2, 3), Real(0.8));
  const Vec3 turn(Real(0.3), Real(-1.2), Real(2.1));
  in.b.rotation = in.a.rotation * from_axis_angle(turn, length(turn));
  const Filled f(kind_of("weld"), in);
  REQUIRE(f.rows.size() == 6);
  for (int k = 0; k < 3; ++k) CHECK(f.rows[3 + k].value == Approx(turn[k]).margin(16 * kEpsilon));
}
