// The explicit midpoint rule (Runge 1895): the slope half a step ahead carries the whole step. Order 2.
// Kept between calls: work arrays. Weak spot: never stable without damping, an oscillator gains (h w)^4/4 of its
// energy per step.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kReach[] = {0, 0.5};
constexpr double kCoupling[] = {0, 0, 0.5, 0};
constexpr double kWeights[] = {0, 1};

class Midpoint final : public Integrator {
 public:
  explicit Midpoint(Arena& a) : Integrator(a), stages_(a, {2, kReach, kCoupling, kWeights}) {}

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

Variant<Integrator> integrate_midpoint() {
  return {"midpoint", "order 2, the slope at half the step; unstable on undamped springs in the long run",
          [](Arena& a, const Params&) -> std::unique_ptr<Integrator> { return std::make_unique<Midpoint>(a); }};
}

}  // namespace feder
