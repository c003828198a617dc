// The stages of a step, in order. `advance` and `solve` form the inner plan that is repeated once per substep.
#pragma once
#include "base/types.h"

namespace feder {

enum class Stage : std::uint8_t { begin, bounds, broad, narrow, advance, solve, finish };
const char* stage_name(Stage stage);

// When a row of the inner plan runs: once before the first substep, in each, or once after the last.
enum class When : std::uint8_t { before_substeps, each_substep, after_substeps };

}  // namespace feder
