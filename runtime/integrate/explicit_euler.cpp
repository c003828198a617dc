// Explicit Euler: x += h v, v += h f(x, v)/m, both from the old state (Euler 1768). Kept between calls: nothing.
// Weak spot: never stable without damping, the energy of an oscillator grows by 1 + (h w)^2 per step. Here as the
// method to compare with.
#include "integrate/integrator.h"

namespace feder {
namespace {

class ExplicitEuler final : public Integrator {
 public:
  explicit ExplicitEuler(Arena& a) : Integrator(a), force_(&a) {}

  IntegratorInfo info() const override {
    static constexpr double kPolynomial[] = {1, 1};
    return {.order = 1,
            .stability_limit = 0,
            .evals_per_step = 1,
            .damped_limit = damped_limit,
            .stability_polynomial = kPolynomial};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    force_.resize(x.size());
    field.eval(x, v, t, force_);
    ++stats.force_evals;
    const std::span<const Real> inv_mass = field.inv_mass();
    const std::span<Vec3> low = low_of(field);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (inv_mass[i] == 0) continue;
      add_compensated(x[i], low[i], h * v[i]);
      v[i] += (h * inv_mass[i]) * force_[i];
    }
  }

 private:
  static double damped_limit(double z) { return z <= 1 ? 2 * z : 2 * (z - std::sqrt(z * z - 1)); }

  Array<Vec3> force_;
};

}  // namespace

Variant<Integrator> integrate_explicit_euler() {
  return variant_of<Integrator, ExplicitEuler>("explicit_euler",
                                               "order 1, never stable on undamped springs: for comparison");
}

}  // namespace feder
