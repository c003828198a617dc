// Checks of sizes while shapes are made: a SceneError says what was expected and what came.
#pragma once
#include <cmath>
#include <string>

#include "feder/error.h"
#include "feder/types.h"

namespace feder {

inline Real positive_size(Real value, const char* shape, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    throw SceneError(std::string(shape) + ": expected a " + what + " above 0, got " + std::to_string(value));
  return value;
}

}  // namespace feder
