// The table of fluid solvers, generated from the feder_variant(fluid ...) lines.
#include "fluid/solver.h"

namespace feder {

using Row = Variant<FluidSolver>;
#include "fluid_declare.inc"

std::span<const Variant<FluidSolver>> fluid_solvers() {
  static const Variant<FluidSolver> table[] = {
#include "fluid_rows.inc"
  };
  return table;
}

}  // namespace feder
