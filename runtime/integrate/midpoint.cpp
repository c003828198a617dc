// The explicit midpoint rule (Runge 1895): the slope half a step ahead carries the whole step. Order 2.
// Kept between calls: work arrays. Weak spot: never stable without damping, an oscillator gains (h w)^4/4 of its
// energy per step.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kNodes[2] = {0, 0.5};
constexpr double kWeights[2] = {0, 1};

}  // namespace

Variant<Integrator> integrate_midpoint() {
  return two_stage_variant<kNodes, kWeights>(
      "midpoint", "order 2, the slope at half the step; unstable on undamped springs in the long run");
}

}  // namespace feder
