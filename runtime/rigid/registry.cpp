// The table of rigid solvers, generated from the feder_variant(rigid ...) lines. Declares the solver by hand because
// the name Row is taken by the constraint rows that solver.h includes.
#include "base/registry.h"

namespace feder {

class RigidSolver;
std::span<const Variant<RigidSolver>> rigid_solvers();
const Variant<RigidSolver>& rigid_solver(const Params& options);

using Row = Variant<RigidSolver>;
#include "rigid_declare.inc"

std::span<const Variant<RigidSolver>> rigid_solvers() {
  static const std::initializer_list<Variant<RigidSolver>> table = {
#include "rigid_rows.inc"
  };
  return {table.begin(), table.size()};
}

const Variant<RigidSolver>& rigid_solver(const Params& options) {
  return variant_option(options, {"solver"}, rigid_solvers(), "soft_step", "rigid solver");
}

}  // namespace feder
