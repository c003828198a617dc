// Weld: frame b stays on frame a, stiff or as a spring of given frequency and damping ratio. One block of six rows:
// the point along the world axes, and the rotation vector theta from frame a to frame b in the axes of frame a. Its
// rate is theta' = J_l^-1(theta) w, with w the relative angular velocity in those axes and
//   J_l^-1 = 1 - [theta]x/2 + (1/theta^2 - cot(theta/2)/(2 theta)) [theta]x^2
// (Chirikjian, "Stochastic Models, Information Theory, and Lie Groups" 2, 10.86). Exact up to half a turn, where the
// rotation vector jumps.
#include "constrain/frames.h"

namespace feder::joints {
namespace {

// Rotation vector of a unit quaternion, length <= pi.
Vec3 rotation_vector(Quat q) {
  if (q.w < 0) q = {-q.x, -q.y, -q.z, -q.w};
  const Real s = length(q.vec());
  if (s < Real(1e-6)) return Real(2) * q.vec();
  return q.vec() * (Real(2) * arc_tan2(s, q.w) / s);
}

// J_l^-1(theta).
Mat3 rate_matrix(const Vec3& theta) {
  const Real angle2 = dot(theta, theta), angle = std::sqrt(angle2);
  Real c = Real(1) / 12;
  if (angle > Real(0.05)) {
    Real s, w;
    sin_cos(angle / 2, s, w);
    c = 1 / angle2 - w / (2 * angle * s);
  } else {
    c += angle2 / 720;
  }
  const Mat3 x = skew(theta);
  return Mat3::Identity() - Real(0.5) * x + c * x * x;
}

void fill(const JointInput& in, RowWriter& out) {
  const WorldFrames f = world_frames(in);
  const Quat rotation =
      conjugate(in.a.rotation * in.joint->frame_a.rotation) * (in.b.rotation * in.joint->frame_b.rotation);
  const Vec3 theta = rotation_vector(rotation);
  const Mat3 rate = rate_matrix(theta) * f.axes_a.transpose();

  Row* rows = out.block(6);
  fill_point_rows(f, in, rows);
  for (int k = 0; k < 3; ++k) {
    Row& row = rows[3 + k];
    row.angular_b = rate.row(k).transpose();
    row.angular_a = -row.angular_b;
    row.value = theta[k];
  }
  for (int k = 0; k < 6; ++k) {
    rows[k].hertz = in.joint->options.spring_hertz;
    rows[k].damping_ratio = in.joint->options.spring_damping;
  }
}

}  // namespace

JointKind constrain_weld() {
  return {"weld", "holds two bodies in one piece, stiff or springy", fill, no_coordinate, kUsesSpring};
}

}  // namespace feder::joints
