// Each substep starts from the rate c = L y + b and moves y by tau phi1(tau L) c, phi1(z) = (e^z - 1)/z, taken
// in the Krylov space of L and c (Saad 1992; Hochbruck & Lubich 1997). The ramp is a further unknown with constant
// rate. Vectors are orthogonal in the energy product x.(M/h^2 - K)x + v.M v: there L is skew but for the damping, which
// only shrinks, and M/h^2, so whatever the tolerance missed, y grows at most by e^(1/2) a step. Exact to rounding where
// the space closes: every net of up to kMaxBasis/6 points, and larger ones of which few modes are excited. Otherwise
// the substep tau is halved until the estimate of Saad (the next term of the series) is small. Kept between calls: work
// arrays. Weak spot: substeps of about kMaxBasis/(2 w), so very stiff large nets cost as much as an explicit method;
// kMaxBasis vectors of 9 doubles per point.
#include "integrate/linear_flow.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr int kMaxBasis = 36;
constexpr int kSmall = kMaxBasis + 2;
constexpr double kTolerance = sizeof(Real) == 4 ? 1e-7 : 1e-13;
constexpr double kHopeless = 0.1;  // error of the smallest substep, relative: more of them would not be better than one
constexpr double kNothing = 1e-140;  // norms whose squares have all digits are above that; what is below does not move
constexpr double kClosed = 1e-14;    // what is left of a vector, relative, when the space is invariant

// c = a b, row-major n x n
void multiply(const double* a, const double* b, double* c, int n) {
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) c[i * n + j] = 0;
    for (int k = 0; k < n; ++k) {
      const double f = a[i * n + k];
      if (f == 0) continue;
      for (int j = 0; j < n; ++j) c[i * n + j] += f * b[k * n + j];
    }
  }
}

}  // namespace

LinearFlow::LinearFlow(Arena& a)
    : x_(&a), v_(&a), rate_x_(&a), rate_v_(&a), product_(&a), basis_x_(&a), basis_v_(&a), basis_p_(&a),
      basis_extra_(&a), hessenberg_(&a), small_(&a), power_(&a), sum_(&a) {}

// out = M^-1 (K x + D v), zero for pinned points
void LinearFlow::apply(std::span<const Vec3d> x, std::span<const Vec3d> v, std::span<Vec3d> out) const {
  system_.k->multiply<Vec3d>(x, out);
  system_.d->multiply<Vec3d>(v, product_);
  for (std::size_t i = 0; i < n_; ++i) out[i] = (out[i] + product_[i]) * static_cast<double>(system_.inv_mass[i]);
}

// out = (M/h^2 - K) x
void LinearFlow::weigh(std::span<const Vec3d> x, std::span<Vec3d> out) const {
  system_.k->multiply<Vec3d>(x, out);
  const double shift = 1 / (h_ * h_);
  for (std::size_t i = 0; i < n_; ++i) out[i] = x[i] * (static_cast<double>(system_.mass[i]) * shift) - out[i];
}

double LinearFlow::project(int i, int j) const {
  double sum = basis_extra_[static_cast<std::size_t>(i)] * basis_extra_[static_cast<std::size_t>(j)];
  const Vec3d *x = basis_x_.data() + static_cast<std::size_t>(i) * n_,
              *p = basis_p_.data() + static_cast<std::size_t>(j) * n_;
  const Vec3d *a = basis_v_.data() + static_cast<std::size_t>(i) * n_,
              *b = basis_v_.data() + static_cast<std::size_t>(j) * n_;
  for (std::size_t k = 0; k < n_; ++k) sum += x[k].dot(p[k]) + static_cast<double>(system_.mass[k]) * a[k].dot(b[k]);
  return sum;
}

// Norm of vector j, which becomes a unit vector (unless it is zero).
double LinearFlow::norm_and_store(int j) {
  weigh(column(basis_x_, j), column(basis_p_, j));
  const double norm = std::sqrt(std::max(0.0, project(j, j)));
  if (!(norm > kNothing)) return 0;
  for (std::size_t i = 0; i < n_; ++i) {
    column(basis_x_, j)[i] /= norm;
    column(basis_v_, j)[i] /= norm;
    column(basis_p_, j)[i] /= norm;
  }
  basis_extra_[static_cast<std::size_t>(j)] /= norm;
  return norm;
}

LinearFlow::Basis LinearFlow::build_basis(double tau) {
  Basis b{n_, 0, 0, false};
  std::copy(rate_x_.begin(), rate_x_.end(), column(basis_x_, 0).begin());
  std::copy(rate_v_.begin(), rate_v_.end(), column(basis_v_, 0).begin());
  basis_extra_[0] = rate_extra_;
  b.beta = norm_and_store(0);
  b.closed = b.beta == 0 || !std::isfinite(b.beta);
  std::fill(hessenberg_.begin(), hessenberg_.end(), 0.0);
  while (!b.closed && b.size < kMaxBasis) {
    const int j = b.size++, next = b.size;
    // the next vector is L times this one, made orthogonal (twice, for rounding) to all before
    const std::span<Vec3d> x = column(basis_x_, next), v = column(basis_v_, next);
    apply(column(basis_x_, j), column(basis_v_, j), v);
    const double extra = basis_extra_[static_cast<std::size_t>(j)];
    for (std::size_t i = 0; i < n_; ++i) {
      x[i] = column(basis_v_, j)[i];
      if (!ramp_.empty()) v[i] += ramp_[i] * (extra * ramp_scale_);
    }
    basis_extra_[static_cast<std::size_t>(next)] = 0;
    weigh(x, column(basis_p_, next));
    const double before = std::sqrt(std::max(0.0, project(next, next)));
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i <= j; ++i) {
        const double share = project(next, i);
        hessenberg_[static_cast<std::size_t>(i * kMaxBasis + j)] += share;
        for (std::size_t k = 0; k < n_; ++k) {
          x[k] -= share * column(basis_x_, i)[k];
          v[k] -= share * column(basis_v_, i)[k];
        }
        basis_extra_[static_cast<std::size_t>(next)] -= share * basis_extra_[static_cast<std::size_t>(i)];
      }
    const double left = norm_and_store(next);
    if (!(left > kClosed * before)) {
      b.closed = true;
    } else {
      hessenberg_[static_cast<std::size_t>(next * kMaxBasis + j)] = left;
      if (b.size % 8 == 0 && b.size < kMaxBasis && error(b, tau) <= kTolerance * tau) break;
    }
  }
  return b;
}

// Fills small_ with exp of [tau H, e1, 0; 0 0 1; 0 0 0]: column `size` is phi1(tau H) e1, the next phi2(tau H) e1.
// Returns the estimated error of the move by tau, per beta.
double LinearFlow::error(const Basis& b, double tau) {
  const int m = b.size, n = m + 2;
  std::fill(small_.begin(), small_.end(), 0.0);
  double largest = 1;
  for (int i = 0; i < m; ++i) {
    double row = 1;
    for (int j = 0; j < m; ++j) {
      small_[static_cast<std::size_t>(i * n + j)] = tau * hessenberg_[static_cast<std::size_t>(i * kMaxBasis + j)];
      row += std::fabs(small_[static_cast<std::size_t>(i * n + j)]);
    }
    largest = std::max(largest, row);
  }
  small_[static_cast<std::size_t>(m)] = 1;
  small_[static_cast<std::size_t>(m * n + m + 1)] = 1;
  // scaling and squaring: the Taylor series of degree 14 for a norm up to a half, then squares
  int squares = 0;
  double scale = 1;
  while (largest * scale > 0.5 && squares < 1000) scale /= 2, ++squares;
  const auto cells = static_cast<std::size_t>(n * n);
  for (std::size_t k = 0; k < cells; ++k) small_[k] *= scale;
  std::fill(sum_.begin(), sum_.end(), 0.0);
  for (int i = 0; i < n; ++i) sum_[static_cast<std::size_t>(i * n + i)] = 1;
  for (int degree = 14; degree >= 1; --degree) {
    multiply(small_.data(), sum_.data(), power_.data(), n);
    for (std::size_t k = 0; k < cells; ++k) sum_[k] = power_[k] / degree;
    for (int i = 0; i < n; ++i) sum_[static_cast<std::size_t>(i * n + i)] += 1;
  }
  for (int k = 0; k < squares; ++k) {
    multiply(sum_.data(), sum_.data(), power_.data(), n);
    std::swap_ranges(sum_.begin(), sum_.end(), power_.begin());
  }
  if (b.closed || m == 0) return 0;
  const double coupling = hessenberg_[static_cast<std::size_t>(m * kMaxBasis + m - 1)];
  return tau * tau * coupling * std::fabs(sum_[static_cast<std::size_t>((m - 1) * n + m + 1)]);
}

// y += beta tau V phi1(tau H) e1, from the last error(b, tau).
void LinearFlow::move(const Basis& b, double tau) {
  const int m = b.size, n = m + 2;
  for (int j = 0; j < m; ++j) {
    const double share = b.beta * tau * sum_[static_cast<std::size_t>(j * n + m)];
    for (std::size_t i = 0; i < n_; ++i) {
      x_[i] += share * column(basis_x_, j)[i];
      v_[i] += share * column(basis_v_, j)[i];
    }
    extra_ += share * basis_extra_[static_cast<std::size_t>(j)];
  }
}

bool LinearFlow::solve(const LinearSystem& s, double h, std::span<const Vec3d> b_x, std::span<const Vec3d> b_v,
                       std::span<const Vec3d> ramp, int max_substeps) {
  system_ = s, h_ = h, ramp_ = ramp;
  n_ = s.mass.size();
  const std::size_t vectors = n_ * (kMaxBasis + 1);
  for (auto* a : {&x_, &v_}) a->assign(n_, Vec3d(0, 0, 0));
  for (auto* a : {&rate_x_, &rate_v_, &product_}) a->resize(n_);
  for (auto* a : {&basis_x_, &basis_v_, &basis_p_}) a->resize(vectors);
  basis_extra_.resize(kMaxBasis + 1);
  hessenberg_.resize((kMaxBasis + 1) * kMaxBasis);
  for (auto* a : {&small_, &power_, &sum_}) a->resize(kSmall * kSmall);

  // the ramp's unknown is scaled to weigh about as much as the rest
  extra_ = rate_extra_ = ramp_scale_ = 0;
  if (!ramp.empty()) {
    double size = 0;
    for (std::size_t i = 0; i < n_; ++i) size += static_cast<double>(s.mass[i]) * ramp[i].squaredNorm();
    size = std::sqrt(size);
    if (!(size > kNothing)) return true;
    ramp_scale_ = 1 / (size * h);
    rate_extra_ = size;  // = (1/h) / ramp_scale
  }

  double done = 0, next = h;
  int substeps = 0;
  bool met = true;
  while (done < h) {
    apply(x_, v_, rate_v_);
    for (std::size_t i = 0; i < n_; ++i) {
      rate_x_[i] = v_[i];
      if (!b_x.empty()) rate_x_[i] += b_x[i], rate_v_[i] += b_v[i];
      if (!ramp.empty()) rate_v_[i] += ramp[i] * (extra_ * ramp_scale_);
    }
    const bool last = ++substeps >= max_substeps;
    double tau = last ? h - done : std::min(next, h - done);
    const Basis basis = build_basis(tau);
    double wrong = error(basis, tau);
    while (!last && wrong > kTolerance * tau && tau * max_substeps > h) {
      tau /= 2;
      wrong = error(basis, tau);
    }
    if (!last && !(wrong <= kHopeless * tau)) tau = h - done, wrong = error(basis, tau);
    if (!(wrong <= kTolerance * tau)) met = false;
    move(basis, tau);
    next = 2 * tau;  // tried from there: each trial costs an exponential
    done = h - done - tau <= 0 ? h : done + tau;
  }
  return met;
}

}  // namespace feder
