// Ralston's method (1962): of the two-stage methods of order 2 the one with the smallest bound on the local error.
// Kept between calls: work arrays. Weak spot: as the midpoint rule, never stable without damping.
#include "integrate/runge_kutta.h"

namespace feder {
namespace {

constexpr double kNodes[2] = {0, 2.0 / 3};
constexpr double kWeights[2] = {0.25, 0.75};

}  // namespace

Variant<Integrator> integrate_rk2() {
  return two_stage_variant<kNodes, kWeights>(
      "rk2", "order 2 (Ralston), smallest error bound of its kind; unstable on undamped springs in the long run");
}

}  // namespace feder
