// Heun's method (1900), the explicit trapezoidal rule: the mean of the slopes at the start and at Euler's end. Order 2.
// Kept between calls: work arrays. Weak spot: as the midpoint rule, never stable without damping.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kNodes[2] = {0, 1};
constexpr double kWeights[2] = {0.5, 0.5};

}  // namespace

Variant<Integrator> integrate_heun() {
  return two_stage_variant<kNodes, kWeights>(
      "heun", "order 2, mean of the slopes at both ends; unstable on undamped springs in the long run");
}

}  // namespace feder
