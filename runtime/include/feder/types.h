// The scalar and the small fixed-size types of the whole project. The only place that names Eigen types.
// SI units, radians, y up, right-handed.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

// On 64-bit ARM Eigen's packets would round otherwise than on x86: products fuse multiply and add (intrinsics, on which
// -ffp-contract=off has no effect) and floats are also added in pairs, as packets of two, where x86 has only packets of
// four. Both are switched off; tests/base/test_rounding.cpp checks the bits of products and sums.
#if defined(__aarch64__) && defined(__ARM_FEATURE_FMA)
#pragma push_macro("__ARM_FEATURE_FMA")
#undef __ARM_FEATURE_FMA
#include <Eigen/Core>
#pragma pop_macro("__ARM_FEATURE_FMA")
#else
#include <Eigen/Core>
#endif
#if defined(__aarch64__) && defined(EIGEN_VECTORIZE_NEON)
namespace Eigen::internal {
template <>
struct find_best_packet<float, 3> {
  using type = Packet4f;
};
template <>
struct find_best_packet<float, 9> {
  using type = Packet4f;
};
}  // namespace Eigen::internal
#endif

namespace feder {

#ifdef FEDER_REAL_DOUBLE
using Real = double;
inline constexpr const char* kRealName = "double";
#else
using Real = float;
inline constexpr const char* kRealName = "float";
#endif

using Vec2 = Eigen::Matrix<Real, 2, 1, Eigen::DontAlign>;
using Vec3 = Eigen::Matrix<Real, 3, 1, Eigen::DontAlign>;
using Mat3 = Eigen::Matrix<Real, 3, 3, Eigen::DontAlign>;

// Double precision for matrices of stiff systems, where float would lose small numbers beside large ones.
using Vec3d = Eigen::Matrix<double, 3, 1, Eigen::DontAlign>;
using Mat3d = Eigen::Matrix<double, 3, 3, Eigen::DontAlign>;

inline constexpr Real kPi = Real(3.14159265358979323846);
inline constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
inline constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();
inline constexpr std::uint32_t kNone = 0xffffffffu;  // "no index" everywhere

// Small vector algebra: what Eigen/Core lacks (cross product, quaternions, 3x3 inverse), and own trigonometry so
// that results do not depend on the C library. Everything here is a pure function.

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

// In double: rounding the length to float is biased, which would add energy and angular momentum to rotating bodies.
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
// Rotation vector (world frame, radians, length <= pi) from `from` to `to`.
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

// Axis-aligned bounding box.
struct Aabb {
  Vec3 lo = Vec3::Constant(kInfinity);
  Vec3 hi = Vec3::Constant(-kInfinity);

  static Aabb everything() { return {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)}; }
  bool empty() const { return !(lo[0] <= hi[0]); }
  void include(const Vec3& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void include(const Aabb& b) { lo = lo.cwiseMin(b.lo), hi = hi.cwiseMax(b.hi); }
  void grow(Real margin) { lo.array() -= margin, hi.array() += margin; }
};

inline bool overlaps(const Aabb& a, const Aabb& b) {
  return a.lo[0] <= b.hi[0] && b.lo[0] <= a.hi[0] && a.lo[1] <= b.hi[1] && b.lo[1] <= a.hi[1] && a.lo[2] <= b.hi[2] &&
         b.lo[2] <= a.hi[2];
}

inline bool contains(const Aabb& outer, const Aabb& inner) {
  return outer.lo[0] <= inner.lo[0] && outer.lo[1] <= inner.lo[1] && outer.lo[2] <= inner.lo[2] &&
         inner.hi[0] <= outer.hi[0] && inner.hi[1] <= outer.hi[1] && inner.hi[2] <= outer.hi[2];
}

// Number in a shape's list of surfaces (ShapeSurface, shape.h): from 1; 0 is the body's own surface.
using SurfaceNumber = std::uint16_t;

}  // namespace feder
