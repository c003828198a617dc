// Free rotation of bodies with uneven moments by the implicit midpoint rule, and what impulses do to their momentum.
#include "rigid/jointed_body.h"

#include <cmath>

#include "feder/error.h"
#include "state/solver_bodies.h"

namespace feder {
namespace {

constexpr Real kSeenTurn = Real(0.05);  // rad, from which on contacts see that a body has turned

Vec3d crossed(const Vec3d& a, const Vec3d& b) {
  return Vec3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

// exp(-[t]x) v, by Rodrigues.
Vec3d rotated_back(const Vec3d& t, const Vec3d& v) {
  const double x2 = t.squaredNorm();
  double straight, bent;  // sin x / x, (1 - cos x) / x^2
  if (x2 < 1e-4) {
    straight = 1 - x2 * (1.0 / 6 - x2 / 120), bent = 0.5 - x2 * (1.0 / 24 - x2 / 720);
  } else {
    const double x = std::sqrt(x2);
    straight = sin_cos_sin(x) / x, bent = (1 - sin_cos_cos(x)) / x2;
  }
  const Vec3d along = crossed(t, v);
  return v - straight * along + bent * crossed(t, along);
}

}  // namespace

Mat3d jointed_axes(const JointedBody& j, const Quat& rotation) {
  FEDER_ASSERT(is_unit(j.principal) && is_unit(rotation));
  const Quat& p = j.principal;
  const double ax = rotation.x, ay = rotation.y, az = rotation.z, aw = rotation.w;
  const double bx = p.x, by = p.y, bz = p.z, bw = p.w;
  double x = aw * bx + ax * bw + ay * bz - az * by, y = aw * by - ax * bz + ay * bw + az * bx;
  double z = aw * bz + ax * by - ay * bx + az * bw, w = aw * bw - ax * bx - ay * by - az * bz;
  const double scale = 1 / std::sqrt(x * x + y * y + z * z + w * w);
  x *= scale, y *= scale, z *= scale, w *= scale;
  Mat3d m;
  m << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),   //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  return m;
}

// Implicit midpoint by Newton's method. Theta = h w in principal axes solves
//   F = I theta/h - exp(-theta/2) L = 0,  dF = I/h - [exp(-theta/2) L]x / 2,
// with (D + [s]x)^-1 = (adj D + s s^T - [D s]x) / (det D + s^T D s). Not by fixed-point iteration: each round
// multiplies the error by (I_t/I_l) (h w)^2/4, which diverges about the long axis of slender bodies (I_t >> I_l).
Vec3 mean_angular_velocity(const JointedBody& j, const Vec3d& momentum, Real h) {
  constexpr int kRounds = 8;
  constexpr double kConverged = 1e-12;  // rad; what is left acts on the smallest moment
  FEDER_ASSERT(h > 0);
  const double step = static_cast<double>(h);
  const Vec3d local = j.axes.transpose() * momentum, d = (j.inv_moments * step).cwiseInverse();
  const Vec3d adjugate(d[1] * d[2], d[2] * d[0], d[0] * d[1]);
  Vec3d theta = j.inv_moments.cwiseProduct(local) * step;
  for (int round = 0; round < kRounds; ++round) {
    const Vec3d middle = rotated_back(theta / 2, local);
    const Vec3d f = d.cwiseProduct(theta) - middle, s = -0.5 * middle, ds = d.cwiseProduct(s);
    const Vec3d off = (adjugate.cwiseProduct(f) + s * s.dot(f) - crossed(ds, f)) / (adjugate[0] * d[0] + s.dot(ds));
    theta -= off;
    if (off.squaredNorm() < kConverged * kConverged) break;
  }
  return (j.axes * (theta / step)).cast<Real>();
}

void start_jointed(JointedBody& j, const Vec3d& momentum, Real h, SolverBody& s) {
  FEDER_ASSERT(j.uneven);
  j.axes = j.free_axes = jointed_axes(j, s.rotation);
  j.momentum = momentum;
  j.share = Vec3d::Ones();
  j.mean_angular_velocity = mean_angular_velocity(j, momentum, h);
  j.correction = Vec3::Zero();
  const Vec3d w = j.axes * j.inv_moments.cwiseProduct(j.axes.transpose() * momentum);
  s.angular_velocity = j.given_angular_velocity = w.cast<Real>();
}

Vec3 push_jointed(JointedBody& j, const Vec3d& moment, SolverBody& s, bool late) {
  FEDER_ASSERT(j.uneven && !(j.share.maxCoeff() > 1));
  const Vec3d felt = j.share.cwiseProduct(j.axes.transpose() * moment);
  const Vec3 change = (j.axes * j.inv_moments.cwiseProduct(felt)).cast<Real>();
  s.angular_velocity += change;
  if (late) return change;
  j.momentum += j.axes * felt;
  j.given_angular_velocity += change;
  return change;
}

Vec3d slender_inv_moments(const Vec3d& inv_moments) { return inv_moments.cwiseMin(10 * inv_moments.minCoeff()); }

Mat3d seen_inv_inertia(const JointedBody& j, const Quat& rotation) {
  const Mat3d axes = jointed_axes(j, rotation);
  const Vec3d seen = j.slender ? slender_inv_moments(j.inv_moments) : j.inv_moments;
  return axes * seen.asDiagonal() * axes.transpose();
}

bool turn_seen(JointedBody& j, const Quat& rotation, Real* change) {
  const Quat& q = j.contact_rotation;
  const Real same = q.x * rotation.x + q.y * rotation.y + q.z * rotation.z + q.w * rotation.w;
  if (same * same > 1 - kSeenTurn * kSeenTurn / 4) return false;
  const Vec3d seen = j.slender ? slender_inv_moments(j.inv_moments) : j.inv_moments;
  const Mat3d old = jointed_axes(j, q), now = jointed_axes(j, rotation);
  const Vec3d given(change[0], change[1], change[2]);
  const Vec3d moment = old * (old.transpose() * given).cwiseQuotient(seen);
  const Vec3d gives = now * (now.transpose() * moment).cwiseProduct(seen);
  for (int k = 0; k < 3; ++k) change[k] = static_cast<Real>(gives[k]);
  j.contact_rotation = rotation;
  return true;
}

Vec3d jointed_momentum(const JointedBody& j, const SolverBody& s) {
  const Vec3 pushed = s.angular_velocity - j.given_angular_velocity;
  if (pushed.isZero(0)) return j.momentum;
  const Mat3d axes = jointed_axes(j, j.slender ? s.rotation : j.contact_rotation);
  return j.momentum + axes * (axes.transpose() * pushed.cast<double>()).cwiseQuotient(j.inv_moments);
}

Vec3d carried_momentum(const JointedBody& j, const SolverBody& s) {
  const Vec3d momentum = jointed_momentum(j, s);
  const Mat3d axes = jointed_axes(j, s.rotation);
  const Vec3d fixed = axes.transpose() * momentum;
  const Vec3d along = j.free_axes.transpose() * rotated_back(-j.correction.cast<double>(), momentum);
  const Vec3d weight = Vec3d::Ones() - j.inv_moments.minCoeff() * j.inv_moments.cwiseInverse();
  return axes * (fixed + weight.cwiseProduct(along - fixed));
}

Vec3 rotate_jointed(JointedBody& j, Real h) {
  const Vec3 rotation = h * mean_angular_velocity(j, j.momentum, h);
  for (int k = 0; k < 3; ++k) j.free_axes.col(k) = rotated_back(-rotation.cast<double>(), j.axes.col(k));
  return rotation;
}

}  // namespace feder
