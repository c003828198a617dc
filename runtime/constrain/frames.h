// Shared by several joint kinds: the frames of a joint in the world, and the rows of a common point.
#pragma once
#include "constrain/joint.h"

namespace feder {

struct WorldAnchors {
  Vec3 arm_a, arm_b;  // from the centres of mass to the anchors, m
  Vec3 gap;           // anchor b - anchor a, m
};

struct WorldFrames : WorldAnchors {
  Mat3 axes_a, axes_b;  // columns: the frames' x, y, z
};

inline WorldAnchors world_anchors(const JointInput& in) {
  WorldAnchors f;
  f.arm_a = rotate(in.a.rotation, in.joint->frame_a.position);
  f.arm_b = rotate(in.b.rotation, in.joint->frame_b.position);
  f.gap = (in.b.position + f.arm_b) - (in.a.position + f.arm_a);
  return f;
}

inline WorldFrames world_frames(const JointInput& in) {
  WorldFrames f;
  static_cast<WorldAnchors&>(f) = world_anchors(in);
  f.axes_a = to_matrix(in.a.rotation * in.joint->frame_a.rotation);
  f.axes_b = to_matrix(in.b.rotation * in.joint->frame_b.rotation);
  return f;
}

// Row along the unit `axis` (fixed in the world) between the two anchors: C = axis . gap.
inline void fill_point_row(const WorldAnchors& f, const Vec3& axis, Row& row) {
  row.linear = axis;
  row.angular_a = cross(axis, f.arm_a);
  row.angular_b = cross(f.arm_b, axis);
  row.value = dot(axis, f.gap);
}

// Bend of the gap between the anchors, m/s; 0 where it is not wanted.
inline Vec3 bend_of_gap(const WorldAnchors& f, const JointInput& in) {
  if (!in.motion_a) return Vec3::Zero();
  return in.motion_b->bend * f.arm_b - in.motion_a->bend * f.arm_a;
}

// Three rows that hold the anchors together, along the world axes.
inline void fill_point_rows(const WorldAnchors& f, const JointInput& in, Row* rows) {
  const Vec3 bend = bend_of_gap(f, in);
  for (int k = 0; k < 3; ++k) {
    Vec3 axis = Vec3::Zero();
    axis[k] = 1;
    fill_point_row(f, axis, rows[k]);
    rows[k].bend = bend[k];
  }
}

// Makes `row` a limit: C >= 0, with C the distance to it (positive: inactive). Its impulse can only increase C.
inline void make_limit(Row& row) {
  row.lower = 0;
  row.upper = kInfinity;
}

inline Real no_coordinate(const JointInput&) { return 0; }

}  // namespace feder
