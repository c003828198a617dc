// Each registered fluid solver in turn.
#pragma once
#include "fluid/solver.h"
#include "support/catch.h"

namespace feder {

inline std::string any_fluid_solver() {
  const int k = GENERATE(range(0, static_cast<int>(fluid_solvers().size())));
  return fluid_solvers()[static_cast<std::size_t>(k)].name;
}

}  // namespace feder
