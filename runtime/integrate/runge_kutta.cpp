#include "integrate/runge_kutta.h"

namespace feder {

void RungeKutta::evaluate(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> v,
                          int first, int last, IntegratorStats& stats) {
  const std::size_t n = x.size(), stages = static_cast<std::size_t>(tableau_.stages);
  force_.resize(n), x_.resize(n), v_.resize(n), slope_x_.resize(n * stages), slope_v_.resize(n * stages);
  const std::span<const Real> inv_mass = field.inv_mass();
  for (int s = first; s < last; ++s) {
    const double* row = tableau_.coupling + s * tableau_.stages;
    x_.assign(x.begin(), x.end());
    v_.assign(v.begin(), v.end());
    for (int k = 0; k < s; ++k) {
      const Real w = h * static_cast<Real>(row[k]);
      if (w == 0) continue;
      const std::span<const Vec3> sx = slope_x(k), sv = slope_v(k);
      for (std::size_t i = 0; i < n; ++i) x_[i] += w * sx[i], v_[i] += w * sv[i];
    }
    field.eval(x_, v_, t + tableau_.reach[s] * static_cast<double>(h), force_);
    ++stats.force_evals;
    const std::span<Vec3> sx = slope_x(s), sv = slope_v(s);
    for (std::size_t i = 0; i < n; ++i) {
      const bool free = inv_mass[i] != 0;
      sx[i] = free ? v_[i] : Vec3(0, 0, 0);
      sv[i] = free ? Vec3(inv_mass[i] * force_[i]) : Vec3(0, 0, 0);
    }
  }
}

void RungeKutta::advance(Real h, const double* weights, std::span<Vec3> x, std::span<Vec3> v) const {
  const std::size_t n = x_.size();
  for (int s = 0; s < tableau_.stages; ++s) {
    const Real w = h * static_cast<Real>(weights[s]);
    if (w == 0) continue;
    const Vec3 *sx = slope_x_.data() + static_cast<std::size_t>(s) * n, *sv = slope_v_.data() + static_cast<std::size_t>(s) * n;
    for (std::size_t i = 0; i < n; ++i) x[i] += w * sx[i], v[i] += w * sv[i];
  }
}

}  // namespace feder
