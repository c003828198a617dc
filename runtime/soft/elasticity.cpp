// What all laws of elasticity share: stretches of a deformation gradient by one-sided Jacobi rotations (Hestenes 1958),
// which give small stretches to their last digit, and the Hessian by corners from derivatives by stretches. Nothing is
// kept. Weak spot: where two stretches are opposite (s_i = -s_j) the rotation of F jumps, and so does the Hessian.
#include "soft/elasticity.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"

namespace feder {
namespace {

constexpr int kSweeps = 20;
constexpr double kOrthogonal = 1e-15;  // cosine of the angle between two columns

double product(const Mat3d& m, int i, int j) { return m(0, i) * m(0, j) + m(1, i) * m(1, j) + m(2, i) * m(2, j); }

Vec3d cross_of(const Vec3d& a, const Vec3d& b) {
  return Vec3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

// Columns p and q turned by the angle of cosine c and sine s.
void turn(Mat3d& m, int p, int q, double c, double s) {
  for (int k = 0; k < 3; ++k) {
    const double x = m(k, p), y = m(k, q);
    m(k, p) = c * x - s * y, m(k, q) = s * x + c * y;
  }
}

// c and s that make alpha, gamma; gamma, beta diagonal.
void jacobi(double alpha, double beta, double gamma, double& c, double& s) {
  const double zeta = (beta - alpha) / (2 * gamma);
  const double t = (zeta >= 0 ? 1.0 : -1.0) / (std::fabs(zeta) + std::sqrt(1 + zeta * zeta));
  c = 1 / std::sqrt(1 + t * t), s = c * t;
}

Vec3d any_across(const Vec3d& n) {
  const Vec3d axis = std::fabs(n[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  const Vec3d c = cross_of(n, axis);
  return c / std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
}

// The nearest symmetric matrix without eigenvalues below 0.
void project_symmetric(double (&a)[3][3]) {
  const double minor = a[0][0] * a[1][1] - a[0][1] * a[0][1];
  Mat3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = a[i][j];
  if (a[0][0] > 0 && minor > 0 && determinant(m) > 0) return;
  Mat3d vectors = Mat3d::Identity();
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (m(p, q) == 0) continue;
        double c, s;
        jacobi(m(p, p), m(q, q), m(p, q), c, s);
        turn(m, p, q, c, s);
        for (int k = 0; k < 3; ++k) {
          const double x = m(p, k), y = m(q, k);
          m(p, k) = c * x - s * y, m(q, k) = s * x + c * y;
        }
        m(p, q) = m(q, p) = 0;
        turn(vectors, p, q, c, s);
      }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      a[i][j] = 0;
      for (int k = 0; k < 3; ++k) a[i][j] += vectors(i, k) * std::fmax(m(k, k), 0) * vectors(j, k);
    }
}

}  // namespace

double determinant(const Mat3d& f) {
  return f(0, 0) * (f(1, 1) * f(2, 2) - f(1, 2) * f(2, 1)) - f(0, 1) * (f(1, 0) * f(2, 2) - f(1, 2) * f(2, 0)) +
         f(0, 2) * (f(1, 0) * f(2, 1) - f(1, 1) * f(2, 0));
}

Mat3d cofactor(const Mat3d& f) {
  Mat3d c;
  c.col(0) = cross_of(f.col(1), f.col(2));
  c.col(1) = cross_of(f.col(2), f.col(0));
  c.col(2) = cross_of(f.col(0), f.col(1));
  return c;
}

Stretches stretches_of(const Mat3d& f) {
  Stretches out;
  Mat3d b = f;  // F V
  out.v = Mat3d::Identity();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool turned = false;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        const double alpha = product(b, p, p), beta = product(b, q, q), gamma = product(b, p, q);
        if (!(std::fabs(gamma) > kOrthogonal * std::sqrt(alpha * beta))) continue;
        double c, s;
        jacobi(alpha, beta, gamma, c, s);
        turn(b, p, q, c, s), turn(out.v, p, q, c, s);
        turned = true;
      }
    if (!turned) break;
  }
  // longest first; an exchange turns, so one of the two changes sign
  const auto order = [&](int i, int j) {
    if (!(product(b, i, i) < product(b, j, j))) return;
    for (Mat3d* m : {&b, &out.v}) {
      const Vec3d x = m->col(i);
      m->col(i) = m->col(j);
      m->col(j) = -x;
    }
  };
  order(0, 1), order(1, 2), order(0, 1);
  const double first = std::sqrt(product(b, 0, 0));
  const Vec3d u0 = first > 0 ? Vec3d(b.col(0) / first) : Vec3d(1, 0, 0);
  Vec3d rest = b.col(1);
  rest -= u0 * (u0[0] * rest[0] + u0[1] * rest[1] + u0[2] * rest[2]);
  const double second = std::sqrt(rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2]);
  const Vec3d u1 = second > 1e-300 ? Vec3d(rest / second) : any_across(u0);
  const Vec3d u2 = cross_of(u0, u1);
  out.u.col(0) = u0, out.u.col(1) = u1, out.u.col(2) = u2;
  for (int k = 0; k < 3; ++k) out.s[k] = out.u(0, k) * b(0, k) + out.u(1, k) * b(1, k) + out.u(2, k) * b(2, k);
  return out;
}

// In the frames of U and V the Hessian couples the entries (i, i) of dF with each other and (i, j) with (j, i).
void corner_stiffness(const ElasticLaw& law, const SoftMaterial& m, const Mat3d& f, const Vec3d (&g)[4], bool project,
                      CornerStiffness& out) {
  const Stretches d = stretches_of(f);
  PrincipalElasticity e = law.principal(m, d.s);
  if (project) {
    project_symmetric(e.stiffness);
    for (int k = 0; k < 3; ++k) e.flip[k] = std::fmax(e.flip[k], 0), e.twist[k] = std::fmax(e.twist[k], 0);
  }
  // of the plane of i and j: stiffness of (i, j) against itself and against (j, i)
  double own[3], cross[3];
  for (int k = 0; k < 3; ++k) own[k] = 0.5 * (e.flip[k] + e.twist[k]), cross[k] = 0.5 * (e.flip[k] - e.twist[k]);
  Vec3d local[4];
  for (int c = 0; c < 4; ++c) local[c].noalias() = d.v.transpose() * g[c];
  const auto block = [&](const Vec3d& a, const Vec3d& b, Mat3d& to) {
    Mat3d inner;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      inner(i, i) = e.stiffness[i][i] * a[i] * b[i] + own[k] * a[j] * b[j] + own[j] * a[k] * b[k];
      inner(i, j) = e.stiffness[i][j] * a[i] * b[j] + cross[k] * a[j] * b[i];
      inner(i, k) = e.stiffness[i][k] * a[i] * b[k] + cross[j] * a[k] * b[i];
    }
    Mat3d half;
    half.noalias() = d.u * inner;
    to.noalias() = half * d.u.transpose();
  };
  for (int c = 0; c < 4; ++c) block(local[c], local[c], out.diagonal[c]);
  for (int n = 0; n < 6; ++n) block(local[kCornerPairs[n][0]], local[kCornerPairs[n][1]], out.off[n]);
}

}  // namespace feder
