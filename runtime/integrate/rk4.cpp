// The classical Runge-Kutta method (Kutta 1901): four evaluations, order 4, applied to (x, v).
// Kept between calls: nothing but work arrays. Weak spot: not symplectic; an oscillator loses about (h w)^6/72 of its
// amplitude per step, and the stability limit per evaluation is a third of Verlet's.
#include "integrate/integrator.h"

namespace feder {
namespace {

class Rk4 final : public Integrator {
 public:
  explicit Rk4(Arena& a) : Integrator(a), force_(&a), x_(&a), v_(&a), x_sum_(&a), v_sum_(&a) {}

  IntegratorInfo info() const override {
    static constexpr double kPolynomial[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};
    return {
        .order = 4, .stability_limit = 2.8284271247461903, .evals_per_step = 4, .stability_polynomial = kPolynomial};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::size_t n = x.size();
    force_.resize(n), x_sum_.resize(n), v_sum_.resize(n);
    x_.assign(x.begin(), x.end());
    v_.assign(v.begin(), v.end());
    for (std::size_t i = 0; i < n; ++i) x_sum_[i] = v_sum_[i] = Vec3::Zero();

    // stage s is evaluated at the start plus c h times the slope of the stage before
    static constexpr double kNodes[4] = {0, 0.5, 0.5, 1};
    static constexpr Real kWeight[4] = {Real(1) / 6, Real(1) / 3, Real(1) / 3, Real(1) / 6};
    const std::span<const Real> inv_mass = field.inv_mass();
    for (int s = 0; s < 4; ++s) {
      field.eval(x_, v_, t + kNodes[s] * static_cast<double>(h), force_);
      ++stats.force_evals;
      const Real next = s < 3 ? static_cast<Real>(kNodes[s + 1]) * h : Real(0);
      for (std::size_t i = 0; i < n; ++i) {
        if (inv_mass[i] == 0) continue;
        const Vec3 slope_x = v_[i], slope_v = inv_mass[i] * force_[i];
        x_sum_[i] += kWeight[s] * slope_x;
        v_sum_[i] += kWeight[s] * slope_v;
        x_[i] = x[i] + next * slope_x;
        v_[i] = v[i] + next * slope_v;
      }
    }
    const std::span<Vec3> low = low_of(field);
    for (std::size_t i = 0; i < n; ++i) {
      add_compensated(x[i], low[i], h * x_sum_[i]);
      v[i] += h * v_sum_[i];
    }
  }

 private:
  Array<Vec3> force_, x_, v_, x_sum_, v_sum_;
};

}  // namespace

Variant<Integrator> integrate_rk4() {
  return variant_of<Integrator, Rk4>("rk4", "order 4, four force evaluations: accurate where the motion is resolved");
}

}  // namespace feder
