// Distance: two anchors keep the rest length, stiff or as a spring of given frequency and damping ratio, and may be
// kept within limits besides. One row along the line of the anchors, C = |gap| - rest_length, and one row per finite
// limit. With limits and no spring the length is free between them (a rope when only the upper one is given).
// Weak spot: coincident anchors have no line; the frame's x axis stands in.
#include "constrain/frames.h"
#include "constrain/joint.h"
#include "feder/error.h"

namespace feder::joints {
namespace {

// (|gap + h rate| - |gap|)/h - line . rate, with the rate of straight motion in the last term.
Real bend_of_length(const WorldAnchors& f, const JointInput& in, Real now, const Vec3& line) {
  const BodyMotion &a = *in.motion_a, &b = *in.motion_b;
  const Vec3 straight =
      b.velocity + cross(b.angular_velocity, f.arm_b) - a.velocity - cross(a.angular_velocity, f.arm_a);
  const Vec3 step = in.h * (straight + bend_of_gap(f, in));
  const Real sum = now + length(Vec3(f.gap + step));
  return sum > 0 ? (2 * dot(f.gap, step) + dot(step, step)) / (sum * in.h) - dot(line, straight) : 0;
}

void fill(const JointInput& in, RowWriter& out) {
  const WorldFrames f = world_frames(in);
  const JointOptions& o = in.joint->options;
  const Real now = length(f.gap);
  const Vec3 line = normalized_or(f.gap, f.axes_a.col(0));

  if (!o.has_limits || o.spring_hertz > 0) {
    FEDER_ASSERT(o.rest_length >= 0);
    Row& row = *out.block(1);
    fill_point_row(f, line, row);
    row.value = now - o.rest_length;
    if (in.motion_a) row.bend = bend_of_length(f, in, now, line);
    row.hertz = o.spring_hertz;
    row.damping_ratio = o.spring_damping;
  }
  if (!o.has_limits) return;
  if (o.lower > -kInfinity) {
    Row& row = *out.block(1);
    fill_point_row(f, line, row);
    row.value = now - o.lower;
    make_limit(row);
  }
  if (o.upper < kInfinity) {
    Row& row = *out.block(1);
    fill_point_row(f, -line, row);
    row.value = o.upper - now;
    make_limit(row);
  }
}

Real coordinate(const JointInput& in) { return length(world_anchors(in).gap); }

}  // namespace

JointKind constrain_distance() {
  return {"distance", "keeps two anchors at a distance: a rod, a spring or a rope", fill, coordinate,
          kUsesTwoAnchors | kUsesSpring | kUsesLimits};
}

}  // namespace feder::joints
