// Small vector algebra: what Eigen/Core lacks (cross product, quaternions, 3x3 inverse), and own trigonometry so
// that results do not depend on the C library. Everything here is a pure function.
#pragma once
#include <cmath>

#include "base/types.h"

namespace feder {

inline Vec3 vec3(Real x, Real y, Real z) { return Vec3(x, y, z); }

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return Vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

inline Real dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Real length(const Vec3& a) { return std::sqrt(dot(a, a)); }

// Unit vector along `a`, or `fallback` when `a` is too short to have a direction.
inline Vec3 normalized_or(const Vec3& a, const Vec3& fallback) {
  const Real n = length(a);
  if (!(n > std::numeric_limits<Real>::min() * Real(16))) return fallback;
  return a / n;
}

inline bool is_finite(Real x) { return std::isfinite(x); }
inline bool is_finite(const Vec3& a) { return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]); }

// Of length 1 to a thousandth: for asserts, so that numbers gone bad (NaN), which are nobody's mistake, pass.
inline bool is_unit(const Vec3& a) { return !(std::fabs(dot(a, a) - 1) > Real(2e-3)); }

inline Real clamp(Real x, Real lo, Real hi) { return x < lo ? lo : (x > hi ? hi : x); }

// [a]x, so that skew(a) * b == cross(a, b).
Mat3 skew(const Vec3& a);

// Inverse of a symmetric positive definite 3x3 matrix by cofactors; zero matrix when singular.
Mat3 inverse(const Mat3& m);

// Two unit vectors that complete the unit vector `n` to a right-handed frame (t1 x t2 = n), without a branch on
// neighbours of n: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017.
void tangent_frame(const Vec3& n, Vec3& t1, Vec3& t2);

// Own trigonometry, radians, evaluated in double: max error about 1e-15 for |x| < 1e5.
void sin_cos(Real x, Real& s, Real& c);
double sin_cos_sin(double x);
double sin_cos_cos(double x);
Real arc_tan2(Real y, Real x);
Real arc_cos(Real x);

// Unit quaternion, x y z w; rotates body to world.
struct Quat {
  Real x = 0, y = 0, z = 0, w = 1;
  static Quat identity() { return {}; }
  Vec3 vec() const { return Vec3(x, y, z); }
};

inline Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

inline Quat conjugate(const Quat& q) { return {-q.x, -q.y, -q.z, q.w}; }

// In double: a length rounded to float is never below 1 by half a unit but above it, and the bias would pump energy
// and angular momentum into spinning bodies.
inline Quat normalized(const Quat& q) {
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  const double n = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(n > 0)) return {};
  const double s = 1 / n;
  return {Real(x * s), Real(y * s), Real(z * s), Real(w * s)};
}

inline bool is_unit(const Quat& q) {
  return !(std::fabs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) > Real(2e-3));
}

inline Vec3 rotate(const Quat& q, const Vec3& v) {
  const Vec3 u = q.vec();
  const Vec3 t = Real(2) * cross(u, v);
  return v + q.w * t + cross(u, t);
}

inline Vec3 rotate_inverse(const Quat& q, const Vec3& v) { return rotate(conjugate(q), v); }

Mat3 to_matrix(const Quat& q);
Quat from_matrix(const Mat3& m);
Quat from_axis_angle(const Vec3& axis, Real angle);  // axis need not be unit; zero axis gives identity
// q advanced by the rotation vector `delta` (world frame, radians): exact exponential map, normalised.
Quat integrate_rotation(const Quat& q, const Vec3& delta);
// Rotation vector (world frame, radians, length <= pi) that turns `from` into `to`.
Vec3 rotation_between(const Quat& from, const Quat& to);
// Shortest rotation taking unit vector a to unit vector b.
Quat rotation_from_to(const Vec3& a, const Vec3& b);

struct Pose {
  Vec3 position = Vec3::Zero();
  Quat rotation;
};

inline Vec3 to_world(const Pose& p, const Vec3& local) { return p.position + rotate(p.rotation, local); }
inline Vec3 to_local(const Pose& p, const Vec3& world) { return rotate_inverse(p.rotation, world - p.position); }
inline Pose operator*(const Pose& a, const Pose& b) { return {to_world(a, b.position), a.rotation * b.rotation}; }

// Eigenvalues (ascending) and unit eigenvectors (columns, right-handed) of a symmetric 3x3 matrix, cyclic Jacobi.
void eigen_symmetric(const Mat3& m, Vec3& values, Mat3& vectors);

}  // namespace feder
