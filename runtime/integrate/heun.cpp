// Heun's method (1900), the explicit trapezoidal rule: the mean of the slopes at the start and at Euler's end. Order 2.
// Kept between calls: work arrays. Weak spot: as the midpoint rule, never stable without damping.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kReach[] = {0, 1};
constexpr double kCoupling[] = {0, 0, 1, 0};
constexpr double kWeights[] = {0.5, 0.5};
constexpr double kPolynomial[] = {1, 1, 0.5};

}  // namespace

Variant<Integrator> integrate_heun() {
  return {"heun", "order 2, mean of the slopes at both ends; unstable on undamped springs in the long run",
          [](Arena& a, const Params&) {
            return tableau_method(a, {2, kReach, kCoupling, kWeights},
                                  {.order = 2, .evals_per_step = 2, .stability_polynomial = kPolynomial});
          }};
}

}  // namespace feder
