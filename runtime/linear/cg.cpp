// Conjugate gradient with a block-Jacobi preconditioner (Hestenes & Stiefel 1952). Fixed points are filtered by
// giving them a zero preconditioner block and zeroing their product (the projection of Baraff & Witkin 1998), so the
// search stays in the space of free points. Everything is double, summed in index order: the same bits on any machine
// and thread count, and the float build reaches its tolerance on stiff systems.
// Kept between calls: work memory only. Weak spot: iterations grow with the square root of the condition number,
// for a chain of n links at a large step about n of them.
#include "linear/cg.h"

#include <cmath>

#include "feder/error.h"

namespace feder {
namespace {

double dot_sum(std::span<const Vec3d> a, std::span<const Vec3d> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 3; ++k) sum += a[i][k] * b[i][k];
  return sum;
}

// Inverse of a diagonal block by LDL^T. A
// block that is not positive definite to rounding gives the inverse of its largest diagonal entry.
Mat3d inverse_block(const Mat3d& m) {
  const double a = m(0, 0), b = m(1, 0), c = m(2, 0), d = m(1, 1), e = m(2, 1), f = m(2, 2);
  const double largest = a > d ? (a > f ? a : f) : (d > f ? d : f);
  if (!(largest > 0)) return Mat3d::Identity();  // not positive definite: the search meets the curvature
  const double floor = largest * 1e-12;
  const Mat3d fallback = Mat3d::Identity() * (1 / largest);
  if (!(a > floor)) return fallback;
  const double l10 = b / a, l20 = c / a, d1 = d - l10 * b;
  if (!(d1 > floor)) return fallback;
  const double l21 = (e - l20 * b) / d1, d2 = f - l20 * c - l21 * l21 * d1;
  if (!(d2 > floor)) return fallback;
  // inverse = L^-T D^-1 L^-1 with L^-1 = [1 0 0; -l10 1 0; t -l21 1]
  const double t = l10 * l21 - l20, i0 = 1 / a, i1 = 1 / d1, i2 = 1 / d2;
  const double m10 = -l10 * i1 - t * l21 * i2, m20 = t * i2, m21 = -l21 * i2;
  Mat3d out;
  out << i0 + l10 * l10 * i1 + t * t * i2, m10, m20, m10, i1 + l21 * l21 * i2, m21, m20, m21, i2;
  return out;
}

}  // namespace

double ConjugateGradient::precondition() {
  for (std::size_t i = 0; i < r_.size(); ++i) z_[i].noalias() = inverse_[i] * r_[i];
  return dot_sum(r_, z_);
}

CgResult ConjugateGradient::solve(const BlockSparse& a, std::span<const Real> free, std::span<const Vec3> b,
                                  const CgOptions& options, std::span<Vec3> x) {
  const std::size_t n = a.diagonal.size();
  FEDER_ASSERT(free.size() == n && b.size() == n && x.size() == n);
  inverse_.resize(n), x_.assign(n, Vec3d(0, 0, 0)), r_.resize(n), z_.resize(n), p_.resize(n), ap_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = Vec3::Zero();
    inverse_[i] = free[i] != 0 ? inverse_block(a.diagonal[i]) : Mat3d(Mat3d::Zero());
    r_[i] = free[i] != 0 ? Vec3d(b[i].cast<double>()) : Vec3d(0, 0, 0);
  }

  CgResult result;
  double rz = precondition();
  const double wanted = rz * options.tolerance * options.tolerance, start = rz;
  if (!(rz > 0)) return result.converged = rz == 0, result;
  for (std::size_t i = 0; i < n; ++i) p_[i] = z_[i];

  while (result.iterations < options.max_iterations) {
    a.multiply<Vec3d>(p_, ap_);
    const double curvature = dot_sum(p_, ap_);
    if (!(curvature > 0)) break;
    const double alpha = rz / curvature;
    for (std::size_t i = 0; i < n; ++i) {
      x_[i] += alpha * p_[i];
      r_[i] -= alpha * ap_[i];
    }
    ++result.iterations;
    // fixed points: their residual is never seen, because the preconditioner block is zero
    const double next = precondition();
    result.residual = std::sqrt(std::fabs(next) / start);
    if (next <= wanted) {
      result.converged = true;
      break;
    }
    const double beta = next / rz;
    for (std::size_t i = 0; i < n; ++i) p_[i] = z_[i] + beta * p_[i];
    rz = next;
  }
  for (std::size_t i = 0; i < n; ++i) x[i] = x_[i].cast<Real>();
  return result;
}

}  // namespace feder
