// Explicit Runge-Kutta stages by a Butcher tableau (Butcher 1963). Kept between calls: slopes and work arrays. Weak
// spot: all slopes are kept, two vectors per stage and point.
#include "integrate/runge_kutta.h"

namespace feder {

void RungeKutta::evaluate(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> low,
                          std::span<const Vec3> v, int first, int last, IntegratorStats& stats) {
  const std::size_t n = x.size(), stages = static_cast<std::size_t>(tableau_.stages);
  force_.resize(n), x_.resize(n), v_.resize(n), slope_x_.resize(n * stages), slope_v_.resize(n * stages);
  const std::span<const Real> inv_mass = field.inv_mass();
  for (int s = first; s < last; ++s) {
    const double* row = tableau_.coupling + s * tableau_.stages;
    x_.assign(x.begin(), x.end());
    low_.assign(low.begin(), low.end());
    v_.assign(v.begin(), v.end());
    add(h, row, s, x_, low_, v_);
    field.eval(x_, v_, t + tableau_.nodes[s] * static_cast<double>(h), force_);
    ++stats.force_evals;
    const std::span<Vec3> sx = slope_x(s), sv = slope_v(s);
    for (std::size_t i = 0; i < n; ++i) {
      const bool free = inv_mass[i] != 0;
      sx[i] = free ? v_[i] : Vec3(0, 0, 0);
      sv[i] = free ? Vec3(inv_mass[i] * force_[i]) : Vec3(0, 0, 0);
    }
  }
}

void RungeKutta::advance(Real h, const double* weights, std::span<Vec3> x, std::span<Vec3> low,
                         std::span<Vec3> v) const {
  add(h, weights, tableau_.stages, x, low, v);
}

// Weights and sums in double, rounded once: weights rounded to float would be another method, whose growth near the
// stability limit differs by 1e-7 per step. With order 5 that moves the limit by 1e-4.
void RungeKutta::add(Real h, const double* weights, int stages, std::span<Vec3> x, std::span<Vec3> low,
                     std::span<Vec3> v) const {
  struct Term {
    double weight;
    const Vec3 *x, *v;
  };
  Term terms[kMaxStages];
  std::size_t count = 0;
  const std::size_t n = x_.size();
  for (int s = 0; s < stages; ++s) {
    const double w = static_cast<double>(h) * weights[s];
    const std::size_t first = static_cast<std::size_t>(s) * n;
    if (w != 0) terms[count++] = {w, slope_x_.data() + first, slope_v_.data() + first};
  }
  if (count == 0) return;
  for (std::size_t i = 0; i < n; ++i) {
    Vec3d dx = Vec3d::Zero(), end_v = v[i].cast<double>();
    for (std::size_t k = 0; k < count; ++k) {
      dx += terms[k].weight * terms[k].x[i].cast<double>();
      end_v += terms[k].weight * terms[k].v[i].cast<double>();
    }
    add_compensated(x[i], low[i], dx.cast<Real>());
    v[i] = end_v.cast<Real>();
  }
}

}  // namespace feder
