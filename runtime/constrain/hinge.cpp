// Hinge: anchors stay together and the x axes of the frames stay parallel; the angle about them is free, limited or
// driven. Five equality rows in one block (three of the point; y_a . x_b = 0 and z_a . x_b = 0), one row per finite
// limit, one motor row. The angle is that of y_b in the y-z plane of frame a, in (-pi, pi]; with two finite limits it
// is measured from their middle, so that limits may lie anywhere on the circle. The rows of the axis are sines of its
// error; beyond 45 degrees they go on with that slope, along y_a and z_a, since sines vanish at 180 degrees. All
// Jacobians are exact derivatives up to 170 degrees; from there to 180 they are the ways that turn b straight back.
// Weak spot: limits wider than 2 pi never act.
#include "constrain/frames.h"

namespace feder::joints {
namespace {

constexpr Real kBent = Real(0.70710678);  // cosine, and sine, of the error of the axis from which rows go on linearly
constexpr Real kOpposed = Real(-0.98480775);  // cosine of 170 degrees

// The angle and its derivative with respect to the relative angular velocity.
Real angle_of(const WorldFrames& f, Vec3& gradient) {
  const Vec3 y_a = f.axes_a.col(1), z_a = f.axes_a.col(2), y_b = f.axes_b.col(1);
  const Real s = dot(z_a, y_b), c = dot(y_a, y_b);
  const Real norm2 = s * s + c * c;
  if (norm2 < Real(1e-6)) {  // y_b along the axis of a: the angle has no meaning, the axis is the best direction
    gradient = f.axes_a.col(0);
    return 0;
  }
  const Vec3 gradient_b = (c * z_a - s * y_a) / norm2;
  gradient = cross(y_b, gradient_b);
  return arc_tan2(s, c);
}

// `x` brought into (-pi, pi], for |x| < 3 pi.
Real wrapped(Real x) {
  if (x > kPi) return x - 2 * kPi;
  if (x <= -kPi) return x + 2 * kPi;
  return x;
}

void fill_angle_row(const Vec3& gradient, Row& row) {
  row.angular_b = gradient;
  row.angular_a = -gradient;
}

// The x axis of b stays on that of a.
void fill_axis_rows(const WorldFrames& f, Row* rows) {
  const Vec3 x_a = f.axes_a.col(0), x_b = f.axes_b.col(0);
  const Real c = dot(x_a, x_b);
  for (int k = 0; k < 2; ++k) {
    const Vec3 side = f.axes_a.col(k + 1);
    fill_angle_row(cross(c < kOpposed ? x_a : x_b, side), rows[k]);
    rows[k].value = dot(side, x_b);
  }
  if (!(c < kBent)) return;
  // value = e(angle) / sin(angle) y, with e the sine continued by its tangent at 45 degrees
  const Real s = std::sqrt(rows[0].value * rows[0].value + rows[1].value * rows[1].value);
  const Real e = kBent * (1 + arc_tan2(s, c) - kPi / 4);
  if (s < Real(1e-4)) {  // any way is as short
    rows[0].value = e, rows[1].value = 0;
    return;
  }
  const Real by_c = (e * c - kBent * s) / (s * s * s);  // derivative of e / sin by c
  for (int k = 0; k < 2; ++k) {
    const Real y = rows[k].value;
    rows[k].value = e / s * y;
    if (c < kOpposed) continue;
    fill_angle_row(e / s * rows[k].angular_b + by_c * y * cross(x_b, x_a), rows[k]);
  }
}

void fill_limit(const Vec3& gradient, Real room, Real sign, Row& row) {
  fill_angle_row(sign * gradient, row);
  row.value = room;
  make_limit(row);
}

void fill(const JointInput& in, RowWriter& out) {
  const WorldFrames f = world_frames(in);
  const JointOptions& o = in.joint->options;

  // point and direction of the axis
  Row* rows = out.block(5);
  fill_point_rows(f, in, rows);
  fill_axis_rows(f, rows + 3);

  // limits
  Vec3 gradient;
  const Real angle = angle_of(f, gradient);
  if (o.has_limits) {
    const bool low = o.lower > -kInfinity, high = o.upper < kInfinity;
    const Real middle = low && high ? Real(0.5) * (o.lower + o.upper) : 0;
    const Real from_middle = wrapped(wrapped(angle - middle));
    if (low) fill_limit(gradient, from_middle - (o.lower - middle), 1, *out.block(1));
    if (high) fill_limit(gradient, (o.upper - middle) - from_middle, -1, *out.block(1));
  }

  // motor
  if (o.has_motor) {
    Row& row = *out.block(1);
    fill_angle_row(gradient, row);
    row.speed = o.motor_speed;
    row.lower = -o.motor_max;
    row.upper = o.motor_max;
    row.velocity_only = true;
  }
}

Real coordinate(const JointInput& in) {
  Vec3 gradient;
  return angle_of(world_frames(in), gradient);
}

}  // namespace

JointKind constrain_hinge() {
  return {"hinge", "turns about one axis, with limits and a motor", fill, coordinate,
          kUsesAxis | kUsesLimits | kUsesMotor};
}

}  // namespace feder::joints
