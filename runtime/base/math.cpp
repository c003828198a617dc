// Own trigonometry by Taylor and argument reduction (Muller, "Elementary Functions", ch. 9 and 11), evaluated in
// double so that the float build is correctly rounded nearly always and every machine agrees bit for bit.
#include "base/trig.h"
#include "feder/types.h"

namespace feder {
namespace {

constexpr double kHalfPiHigh = 1.57079632679489655800e+00;  // pi/2 rounded to double
constexpr double kHalfPiLow = 6.12323399573676603587e-17;   // pi/2 - kHalfPiHigh

void sin_cos_double(double x, double& s, double& c) {
  const double k = std::floor(x / kHalfPiHigh + 0.5);
  const double r = (x - k * kHalfPiHigh) - k * kHalfPiLow;  // |r| <= pi/4
  const double sr = taylor_sine(r), cr = taylor_cosine(r);
  const double quadrant = k - 4.0 * std::floor(k / 4.0);
  if (quadrant == 0.0) {
    s = sr, c = cr;
  } else if (quadrant == 1.0) {
    s = cr, c = -sr;
  } else if (quadrant == 2.0) {
    s = -sr, c = -cr;
  } else {
    s = -cr, c = sr;
  }
}

// atan for 0 <= x <= 1: one reduction about c = tan(pi/8) leaves |t| <= tan(pi/8)/... < 0.2, then the odd series.
double arc_tan_unit(double x) {
  constexpr double kSteps[4] = {0.12435499454676144, 0.24497866312686414, 0.46364760900080609, 0.78539816339744828};
  constexpr double kTangents[4] = {0.125, 0.25, 0.5, 1.0};
  double base = 0.0, t = x;
  if (x > 0.75) {
    base = kSteps[3], t = (x - 1.0) / (1.0 + x);
  } else if (x > 0.375) {
    base = kSteps[2], t = (x - kTangents[2]) / (1.0 + x * kTangents[2]);
  } else if (x > 0.1875) {
    base = kSteps[1], t = (x - kTangents[1]) / (1.0 + x * kTangents[1]);
  } else if (x > 0.0625) {
    base = kSteps[0], t = (x - kTangents[0]) / (1.0 + x * kTangents[0]);
  }
  const double z = t * t;
  double p = 0.0;
  for (int n = 23; n >= 1; n -= 2) p = 1.0 / n - z * p;
  return base + t * p;
}

}  // namespace

void sin_cos(Real x, Real& s, Real& c) {
  double sd, cd;
  sin_cos_double(static_cast<double>(x), sd, cd);
  s = static_cast<Real>(sd);
  c = static_cast<Real>(cd);
}

double sin_cos_sin(double x) {
  double s, c;
  sin_cos_double(x, s, c);
  return s;
}

double sin_cos_cos(double x) {
  double s, c;
  sin_cos_double(x, s, c);
  return c;
}

double arc_tangent2(double y, double x) {
  const double ax = std::fabs(x), ay = std::fabs(y);
  if (ax == 0.0 && ay == 0.0) return 0;
  double a = ay <= ax ? arc_tan_unit(ay / ax) : kHalfPiHigh - arc_tan_unit(ax / ay);
  if (x < 0) a = 2.0 * kHalfPiHigh - a;
  return y < 0 ? -a : a;
}

Real arc_tan2(Real y, Real x) {
  return static_cast<Real>(arc_tangent2(static_cast<double>(y), static_cast<double>(x)));
}

Real arc_cos(Real x) {
  const double c = x < -1 ? -1.0 : (x > 1 ? 1.0 : static_cast<double>(x));
  const double s = std::sqrt((1.0 - c) * (1.0 + c));
  return arc_tan2(static_cast<Real>(s), static_cast<Real>(c));
}

Mat3 skew(const Vec3& a) {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

Mat3 inverse(const Mat3& m) {
  // of the matrix with a largest entry of one: determinants of small and large bodies leave the range
  const Real size = m.cwiseAbs().maxCoeff();
  if (!(size > 0) || !std::isfinite(size)) return Mat3::Zero();
  const Mat3 unit = m / size;
  const Vec3 c0 = unit.col(0), c1 = unit.col(1), c2 = unit.col(2);
  const Vec3 r0 = cross(c1, c2), r1 = cross(c2, c0), r2 = cross(c0, c1);
  const Real det = dot(c0, r0) * size;
  if (det == 0 || !std::isfinite(det)) return Mat3::Zero();
  Mat3 out;
  out.row(0) = r0.transpose() / det;
  out.row(1) = r1.transpose() / det;
  out.row(2) = r2.transpose() / det;
  return out;
}

void tangent_frame(const Vec3& n, Vec3& t1, Vec3& t2) {
  const Real sign = std::copysign(Real(1), n[2]);
  const Real a = Real(-1) / (sign + n[2]);
  const Real b = n[0] * n[1] * a;
  t1 = Vec3(Real(1) + sign * n[0] * n[0] * a, sign * b, -sign * n[0]);
  t2 = Vec3(b, sign + n[1] * n[1] * a, -n[1]);
}

Mat3 to_matrix(const Quat& q) {
  const Real xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const Real xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const Real wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  Mat3 m;
  m << 1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy),  //
      2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx),   //
      2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy);
  return m;
}

Quat from_matrix(const Mat3& m) {
  // the largest of the four squared components decides (Shepperd 1978)
  const Real trace = m(0, 0) + m(1, 1) + m(2, 2);
  Quat q;
  if (trace > 0) {
    q = {m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1), 1 + trace};
  } else if (m(0, 0) >= m(1, 1) && m(0, 0) >= m(2, 2)) {
    q = {1 + m(0, 0) - m(1, 1) - m(2, 2), m(0, 1) + m(1, 0), m(0, 2) + m(2, 0), m(2, 1) - m(1, 2)};
  } else if (m(1, 1) >= m(2, 2)) {
    q = {m(0, 1) + m(1, 0), 1 + m(1, 1) - m(0, 0) - m(2, 2), m(1, 2) + m(2, 1), m(0, 2) - m(2, 0)};
  } else {
    q = {m(0, 2) + m(2, 0), m(1, 2) + m(2, 1), 1 + m(2, 2) - m(0, 0) - m(1, 1), m(1, 0) - m(0, 1)};
  }
  return normalized(q);
}

Quat from_axis_angle(const Vec3& axis, Real angle) {
  const Real n = length(axis);
  if (!(n > 0)) return {};
  Real s, c;
  sin_cos(angle / 2, s, c);
  const Vec3 v = axis * (s / n);
  return {v[0], v[1], v[2], c};
}

Quat integrate_rotation(const Quat& q, const Vec3& delta) {
  const Real angle2 = dot(delta, delta);
  Real s, c;  // s = sin(angle/2)/angle
  if (angle2 < Real(0.01)) {
    // series: exact to rounding for small angles, and no division by zero
    s = Real(0.5) - angle2 * (Real(1) / 48 - angle2 * (Real(1) / 3840 - angle2 / 645120));
    c = Real(1) - angle2 * (Real(1) / 8 - angle2 * (Real(1) / 384 - angle2 / 46080));
  } else {
    const Real angle = std::sqrt(angle2);
    sin_cos(angle / 2, s, c);
    s /= angle;
  }
  return normalized(Quat{delta[0] * s, delta[1] * s, delta[2] * s, c} * q);
}

Vec3 rotation_between(const Quat& from, const Quat& to) {
  Quat d = to * conjugate(from);
  if (d.w < 0) d = {-d.x, -d.y, -d.z, -d.w};
  const Vec3 v = d.vec();
  const Real n = length(v);
  if (n < Real(1e-7)) return v * Real(2);
  return v * (Real(2) * arc_tan2(n, d.w) / n);
}

Quat rotation_from_to(const Vec3& a, const Vec3& b) {
  const Real c = dot(a, b);
  if (c < Real(-1) + 16 * kEpsilon) {
    Vec3 t1, t2;
    tangent_frame(a, t1, t2);
    return {t1[0], t1[1], t1[2], 0};
  }
  const Vec3 v = cross(a, b);
  return normalized(Quat{v[0], v[1], v[2], 1 + c});
}

void eigen_symmetric(const Mat3& m, Vec3& values, Mat3& vectors) {
  // cyclic Jacobi (Golub & Van Loan 8.5); ten sweeps are far more than a 3x3 needs
  Mat3 a = m;
  vectors = Mat3::Identity();
  for (int sweep = 0; sweep < 10; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (a(p, q) == 0) continue;
        const Real theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const Real t = (theta >= 0 ? Real(1) : Real(-1)) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const Real c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const Real x = a(k, p), y = a(k, q);
          a(k, p) = c * x - s * y, a(k, q) = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const Real x = a(p, k), y = a(q, k);
          a(p, k) = c * x - s * y, a(q, k) = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const Real x = vectors(k, p), y = vectors(k, q);
          vectors(k, p) = c * x - s * y, vectors(k, q) = s * x + c * y;
        }
      }
    }
  }
  // ascending, then make the frame right-handed
  int order[3] = {0, 1, 2};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2 - i; ++j)
      if (a(order[j], order[j]) > a(order[j + 1], order[j + 1])) std::swap(order[j], order[j + 1]);
  Mat3 sorted;
  for (int i = 0; i < 3; ++i) values[i] = a(order[i], order[i]), sorted.col(i) = vectors.col(order[i]);
  if (dot(cross(sorted.col(0), sorted.col(1)), sorted.col(2)) < 0) sorted.col(2) = -sorted.col(2);
  vectors = sorted;
}

}  // namespace feder
