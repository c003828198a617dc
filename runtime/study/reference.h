// References by other means than the library's own: extrapolated integration in long double, linear modes, Jacobi's
// elliptic functions. Slow and exact; never in a step. Private to the module and its tests.
#pragma once
#include <functional>
#include <vector>

namespace feder {

using Wide = long double;

// y' = f(t, y) by Gragg-Bulirsch-Stoer extrapolation (Hairer, Norsett, Wanner, Solving ODEs I, II.9): modified midpoint
// with 2, 4, ... 20 substeps. `tolerance`: error per step against the largest value of a component so far. Keeps the
// states at equidistant times; other times are integrated from the one before.
class OdeReference {
 public:
  using Rhs = std::function<void(Wide t, const Wide* y, Wide* dy)>;
  OdeReference(Rhs rhs, std::vector<Wide> start, double t_end, int samples, Wide tolerance = 1e-16L);
  // Computes what is missing up to t; t within [0, t_end].
  const std::vector<Wide>& at(double t);
  long evaluations() const { return evaluations_; }

 private:
  void advance(Wide from, Wide to, std::vector<Wide>& y, Wide& step);
  bool extrapolate(Wide t, Wide h, const std::vector<Wide>& y, int& rows);
  void midpoint(Wide t, Wide h, int n, const std::vector<Wide>& y, std::vector<Wide>& out);

  Rhs rhs_;
  double t_end_;
  int samples_;
  Wide tolerance_;
  std::vector<std::vector<Wide>> states_;
  Wide step_;
  std::vector<Wide> largest_, between_, slope_, previous_, current_;
  std::vector<std::vector<Wide>> table_;
  long evaluations_ = 0;
};

// M u'' = -K u from u0, v0 by the eigenvectors of M^-1/2 K M^-1/2 (cyclic Jacobi).
class LinearModes {
 public:
  // `stiffness` row by row.
  LinearModes(const std::vector<Wide>& stiffness, const std::vector<Wide>& mass, const std::vector<Wide>& u0,
              const std::vector<Wide>& v0);
  void at(double t, std::vector<double>& u, std::vector<double>& v) const;
  const std::vector<Wide>& frequencies() const { return frequency_; }  // ascending, 1/s
  // The k-th mode's shape, largest component 1.
  std::vector<double> shape(std::size_t k) const;

 private:
  std::size_t n_;
  std::vector<Wide> frequency_, vectors_, root_mass_, u_, v_;
};

// x'' = -k x - 2 decay x' from (1, 0), for every damping ratio:
//   x = e^(-decay t) (cos w t + decay/w sin w t), v = -e^(-decay t) k/w sin w t, w = sqrt(k - decay^2),
// with hyperbolic functions beyond the critical ratio, written with the two real roots because they would overflow.
void damped_oscillation(double k, double decay, double t, double& x, double& v);

// Eigenvalues (ascending) and orthonormal eigenvectors (columns) of a symmetric n x n matrix.
void eigen_symmetric(std::vector<Wide> a, std::size_t n, std::vector<Wide>& values, std::vector<Wide>& vectors);

// K(m), m = k^2, with m1 = 1 - m given apart because it may be tiny.
Wide elliptic_k(Wide m1);
// sn, cn, dn of u by descending Landen transformation (arithmetic-geometric mean).
void jacobi_elliptic(Wide u, Wide m, Wide m1, Wide& sn, Wide& cn, Wide& dn);

}  // namespace feder
