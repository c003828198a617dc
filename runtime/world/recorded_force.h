// Forces that a host makes, while a world is recorded: what they answer goes into the log, for a replay has no host.
#pragma once
#include <memory>

#include "feder/force.h"
#include "state/command_log.h"

namespace feder {

// What owners of a force ask of it once, as bits; 0: no force.
inline constexpr int kForceThere = 1, kForceOfVelocity = 2, kForceOnArea = 4;
inline int traits_of(const Force* force) {
  return force ? kForceThere | (force->depends_on_velocity() ? kForceOfVelocity : 0) |
                     (force->on_area() ? kForceOnArea : 0)
               : 0;
}

std::shared_ptr<const Force> recorded_force(std::shared_ptr<const Force> force, CommandLog& log);

}  // namespace feder
