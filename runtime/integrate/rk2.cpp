// Ralston's method (1962): of the two-stage methods of order 2 the one with the smallest bound on the local error.
// Kept between calls: work arrays. Weak spot: as the midpoint rule, never stable without damping.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kReach[] = {0, 2.0 / 3};
constexpr double kCoupling[] = {0, 0, 2.0 / 3, 0};
constexpr double kWeights[] = {0.25, 0.75};
constexpr double kPolynomial[] = {1, 1, 0.5};

}  // namespace

Variant<Integrator> integrate_rk2() {
  return {"rk2", "order 2 (Ralston), smallest error bound of its kind; unstable on undamped springs in the long run",
          [](Arena& a, const Params&) {
            return tableau_method(a, {2, kReach, kCoupling, kWeights},
                                  {.order = 2, .evals_per_step = 2, .stability_polynomial = kPolynomial});
          }};
}

}  // namespace feder
