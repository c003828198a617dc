// Ralston's method (1962): of the two-stage methods of order 2 the one with the smallest bound on the local error.
// Kept between calls: work arrays. Weak spot: as the midpoint rule, never stable without damping.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kReach[] = {0, 2.0 / 3};
constexpr double kCoupling[] = {0, 0, 2.0 / 3, 0};
constexpr double kWeights[] = {0.25, 0.75};

class Rk2 final : public Integrator {
 public:
  explicit Rk2(Arena& a) : Integrator(a), stages_(a, {2, kReach, kCoupling, kWeights}) {}

  IntegratorInfo info() const override {
    static constexpr double kPolynomial[] = {1, 1, 0.5};
    return {.order = 2, .stability_limit = 0, .evals_per_step = 2, .stability_polynomial = kPolynomial};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    stages_.step(field, t, h, x, v, stats);
  }

 private:
  RungeKutta stages_;
};

}  // namespace

Variant<Integrator> integrate_rk2() {
  return {"rk2", "order 2 (Ralston), smallest error bound of its kind; unstable on undamped springs in the long run",
          [](Arena& a, const Params&) -> std::unique_ptr<Integrator> { return std::make_unique<Rk2>(a); }};
}

}  // namespace feder
