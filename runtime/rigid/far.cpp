// Rounding far from the origin: neighbouring numbers are so far apart there that slow motion is lost, because body
// positions are plain sums without compensation. Warns once per world.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kVisibleSpeed = Real(0.3);  // m/s: slower motion is not missed

Real largest(const Vec3& x) { return std::max({std::fabs(x[0]), std::fabs(x[1]), std::fabs(x[2])}); }

}  // namespace

// The motion of a step is lost where it is less than half the distance of neighbouring numbers.
void Rigid::Impl::check_far(StepContext& c) {
  const Real far = kVisibleSpeed * c.dt * 2 / kEpsilon;  // m
  const auto lost = [&](std::uint32_t i) {
    const Real away = largest(bodies.position[i]);
    if (!(away > far)) return false;
    const Real speed = largest(bodies.velocity[i]);
    return speed > kVisibleSpeed && speed * c.dt < away * kEpsilon / 2;
  };
  const auto found = std::find_if(moving.begin(), moving.end(), lost);
  if (found == moving.end()) return;
  warned_far = true;
  const std::uint32_t i = *found;
  const Real spacing = largest(bodies.position[i]) * kEpsilon;
  const auto text = [](Real x) {
    char out[32];
    std::snprintf(out, sizeof out, "%.2g", static_cast<double>(x));
    return std::string(out);
  };
  events.warn("far",
              objects.describe(bodies.object[i]) + " is " + text(largest(bodies.position[i])) +
                  " m from the origin, where numbers are " + text(spacing) + " m apart: motion below " +
                  text(spacing / (2 * c.dt)) + " m/s gets lost; build the scene round the origin" +
                  (sizeof(Real) == 4 ? ", or take the double build" : ""),
              bodies.object[i]);
}

}  // namespace feder
