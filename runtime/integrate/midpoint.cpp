// The explicit midpoint rule (Runge 1895): the slope half a step ahead carries the whole step. Order 2.
// Kept between calls: work arrays. Weak spot: never stable without damping, an oscillator gains (h w)^4/4 of its
// energy per step.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kReach[] = {0, 0.5};
constexpr double kCoupling[] = {0, 0, 0.5, 0};
constexpr double kWeights[] = {0, 1};
constexpr double kPolynomial[] = {1, 1, 0.5};

}  // namespace

Variant<Integrator> integrate_midpoint() {
  return {"midpoint", "order 2, the slope at half the step; unstable on undamped springs in the long run",
          [](Arena& a, const Params&) {
            return tableau_method(a, {2, kReach, kCoupling, kWeights},
                                  {.order = 2, .evals_per_step = 2, .stability_polynomial = kPolynomial});
          }};
}

}  // namespace feder
