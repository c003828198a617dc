// Gragg-Bulirsch-Stoer extrapolation (Hairer, Norsett & Wanner 1993, II.9), cyclic Jacobi (Golub & Van Loan 2013, 8.5)
// and Jacobi's elliptic functions (Abramowitz & Stegun 1964, 16.4). Weak spot: explicit, so stiff problems take it
// long; long double is no wider than double on some machines.
#include "study/reference.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace feder {
namespace {

constexpr int kRows = 10;
constexpr Wide kPiWide = 3.14159265358979323846264338327950288L;

}  // namespace

OdeReference::OdeReference(Rhs rhs, std::vector<Wide> start, double t_end, int samples, Wide tolerance)
    : rhs_(std::move(rhs)), t_end_(t_end), samples_(samples), tolerance_(tolerance),
      step_(static_cast<Wide>(t_end) / samples) {
  largest_.resize(start.size());
  between_ = slope_ = previous_ = current_ = largest_;
  table_.assign(kRows, largest_);
  states_.push_back(std::move(start));
}

const std::vector<Wide>& OdeReference::at(double t) {
  const double sample = t / t_end_ * (samples_ - 1);
  const auto k = static_cast<std::size_t>(std::floor(sample + 1e-9));
  const auto time = [&](std::size_t i) { return static_cast<Wide>(t_end_) * static_cast<Wide>(i) / (samples_ - 1); };
  while (states_.size() <= k) {
    std::vector<Wide> y = states_.back();
    advance(time(states_.size() - 1), time(states_.size()), y, step_);
    states_.push_back(std::move(y));
  }
  if (std::fabs(sample - static_cast<double>(k)) < 1e-9) return states_[k];
  previous_ = states_[k];
  Wide step = step_;
  advance(time(k), static_cast<Wide>(t), previous_, step);
  return previous_;
}

void OdeReference::advance(Wide from, Wide to, std::vector<Wide>& y, Wide& step) {
  Wide t = from;
  while (t < to) {
    const Wide left = to - t;
    const bool last = step >= left;
    const Wide h = last ? left : step;
    Wide top = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      largest_[i] = std::max(largest_[i], std::fabs(y[i]));
      top = std::max(top, largest_[i]);
    }
    // small components are known to the rounding of the others only
    for (Wide& x : largest_) x = std::max(x, 0.01L * top);
    int rows = 0;
    if (!extrapolate(t, h, y, rows)) {
      step = h / 2;
      if (step < 1e-15L * (to - from)) return;  // not to be had; the tests of the digits would find it
      continue;
    }
    y = current_;
    t = last ? to : t + h;
    if (rows <= 7 && !last)
      step = h * 1.3L;
    else if (rows >= 10)
      step = h * 0.8L;
  }
}

bool OdeReference::extrapolate(Wide t, Wide h, const std::vector<Wide>& y, int& rows) {
  for (int j = 0; j < kRows; ++j) {
    const int n = 2 * (j + 1);
    midpoint(t, h, n, y, current_);
    // Neville in 1/n^2: table_[i] holds the row's entry of column i
    Wide worst = 0;
    for (std::size_t c = 0; c < y.size(); ++c) {
      Wide value = current_[c];
      for (int i = 0; i < j; ++i) {
        const Wide ratio = static_cast<Wide>(n) / (2 * (j - i));
        const Wide better = value + (value - table_[static_cast<std::size_t>(i)][c]) / (ratio * ratio - 1);
        table_[static_cast<std::size_t>(i)][c] = value;
        const Wide error = std::fabs(better - value) / std::max(largest_[c], std::fabs(better));
        if (i == j - 1 && !(error <= worst)) worst = error;  // NaN too
        value = better;
      }
      table_[static_cast<std::size_t>(j)][c] = value;
      current_[c] = value;
    }
    if (!std::isfinite(worst)) return false;
    if (j > 2 && worst <= tolerance_) {
      rows = j + 1;
      return true;
    }
  }
  return false;
}

void OdeReference::midpoint(Wide t, Wide h, int n, const std::vector<Wide>& y, std::vector<Wide>& out) {
  const Wide s = h / n;
  rhs_(t, y.data(), slope_.data());
  std::vector<Wide>& before = out;  // z_{m-1}
  before = y;
  for (std::size_t i = 0; i < y.size(); ++i) between_[i] = y[i] + s * slope_[i];
  for (int m = 1; m < n; ++m) {
    rhs_(t + m * s, between_.data(), slope_.data());
    for (std::size_t i = 0; i < y.size(); ++i) {
      const Wide next = before[i] + 2 * s * slope_[i];
      before[i] = between_[i];
      between_[i] = next;
    }
  }
  rhs_(t + h, between_.data(), slope_.data());
  for (std::size_t i = 0; i < y.size(); ++i) out[i] = (before[i] + between_[i] + s * slope_[i]) / 2;
  evaluations_ += n + 1;
}

void damped_oscillation(double k, double decay, double t, double& x, double& v) {
  const double square = k - decay * decay;
  if (std::fabs(square) < 1e-12 * k) {  // critical
    const double w = std::sqrt(k), e = std::exp(-w * t);
    x = (1 + w * t) * e;
    v = -k * t * e;
  } else if (square > 0) {
    const double w = std::sqrt(square), e = std::exp(-decay * t);
    x = e * (std::cos(w * t) + decay / w * std::sin(w * t));
    v = -e * k / w * std::sin(w * t);
  } else {
    const double root = std::sqrt(-square), fast = decay + root, slow = k / fast;  // product of the roots is k
    x = (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow);
    v = k * (std::exp(-fast * t) - std::exp(-slow * t)) / (fast - slow);
  }
}

void eigen_symmetric(std::vector<Wide> a, std::size_t n, std::vector<Wide>& values, std::vector<Wide>& vectors) {
  std::vector<Wide> v(n * n, 0);
  for (std::size_t i = 0; i < n; ++i) v[i * n + i] = 1;
  for (int sweep = 0; sweep < 60; ++sweep) {
    Wide off = 0, all = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) (i == j ? all : off) += a[i * n + j] * a[i * n + j];
    if (off <= 1e-42L * (all + off)) break;
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        if (a[p * n + q] == 0) continue;
        const Wide theta = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
        const Wide t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const Wide c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (std::size_t k = 0; k < n; ++k) {
          const Wide x = a[k * n + p], y = a[k * n + q];
          a[k * n + p] = c * x - s * y, a[k * n + q] = s * x + c * y;
        }
        for (std::size_t k = 0; k < n; ++k) {
          const Wide x = a[p * n + k], y = a[q * n + k];
          a[p * n + k] = c * x - s * y, a[q * n + k] = s * x + c * y;
          const Wide u = v[k * n + p], w = v[k * n + q];
          v[k * n + p] = c * u - s * w, v[k * n + q] = s * u + c * w;
        }
      }
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i * n + i] < a[j * n + j]; });
  values.resize(n), vectors.resize(n * n);
  for (std::size_t j = 0; j < n; ++j) {
    values[j] = a[order[j] * n + order[j]];
    for (std::size_t i = 0; i < n; ++i) vectors[i * n + j] = v[i * n + order[j]];
  }
}

LinearModes::LinearModes(const std::vector<Wide>& stiffness, const std::vector<Wide>& mass, const std::vector<Wide>& u0,
                         const std::vector<Wide>& v0)
    : n_(mass.size()), u_(n_, 0), v_(n_, 0) {
  for (const Wide m : mass) root_mass_.push_back(std::sqrt(m));
  std::vector<Wide> a(n_ * n_), values;
  Wide top = 0;
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = 0; j < n_; ++j) {
      a[i * n_ + j] = stiffness[i * n_ + j] / (root_mass_[i] * root_mass_[j]);
      top = std::max(top, std::fabs(a[i * n_ + j]));
    }
  eigen_symmetric(std::move(a), n_, values, vectors_);
  for (const Wide w2 : values) frequency_.push_back(w2 > 1e-16L * top ? std::sqrt(w2) : 0);
  for (std::size_t k = 0; k < n_; ++k)
    for (std::size_t i = 0; i < n_; ++i) {
      u_[k] += vectors_[i * n_ + k] * root_mass_[i] * u0[i];
      v_[k] += vectors_[i * n_ + k] * root_mass_[i] * v0[i];
    }
}

void LinearModes::at(double t, std::vector<double>& u, std::vector<double>& v) const {
  std::vector<Wide> x(n_, 0), y(n_, 0);
  for (std::size_t k = 0; k < n_; ++k) {
    const Wide w = frequency_[k], c = std::cos(w * static_cast<Wide>(t)), s = std::sin(w * static_cast<Wide>(t));
    const Wide p = w > 0 ? u_[k] * c + v_[k] / w * s : u_[k] + v_[k] * static_cast<Wide>(t);
    const Wide q = v_[k] * c - u_[k] * w * s;
    for (std::size_t i = 0; i < n_; ++i) x[i] += vectors_[i * n_ + k] * p, y[i] += vectors_[i * n_ + k] * q;
  }
  u.resize(n_), v.resize(n_);
  for (std::size_t i = 0; i < n_; ++i) {
    u[i] = static_cast<double>(x[i] / root_mass_[i]);
    v[i] = static_cast<double>(y[i] / root_mass_[i]);
  }
}

std::vector<double> LinearModes::shape(std::size_t k) const {
  std::vector<double> out(n_);
  double top = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    out[i] = static_cast<double>(vectors_[i * n_ + k] / root_mass_[i]);
    if (std::fabs(out[i]) > std::fabs(top)) top = out[i];
  }
  for (double& x : out) x /= top;
  return out;
}

Wide elliptic_k(Wide m1) {
  Wide a = 1, b = std::sqrt(m1);
  for (int i = 0; i < 60 && std::fabs(a - b) > 1e-20L * a; ++i) {
    const Wide mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return kPiWide / (2 * a);
}

// Abramowitz & Stegun 16.4.
void jacobi_elliptic(Wide u, Wide m, Wide m1, Wide& sn, Wide& cn, Wide& dn) {
  Wide a[32], c[32];
  a[0] = 1, c[0] = std::sqrt(m);
  Wide b = std::sqrt(m1);
  int n = 0;
  while (n < 30 && std::fabs(c[n]) > 1e-20L) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
    ++n;
  }
  Wide phi = std::ldexp(a[n] * u, n);
  for (int k = n; k > 0; --k) phi = (phi + std::asin(c[k] / a[k] * std::sin(phi))) / 2;
  sn = std::sin(phi), cn = std::cos(phi);
  // not as the quotient of cosines, which is 0/0 at the quarter period
  dn = std::sqrt(m1 + m * cn * cn);
}

}  // namespace feder
