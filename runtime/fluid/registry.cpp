// The table of fluid solvers, generated from the feder_variant(fluid ...) lines.
#include "feder/fluid.h"
#include "fluid/solver.h"

namespace feder {

using Row = Variant<FluidSolver>;
#include "fluid_declare.inc"

std::span<const Variant<FluidSolver>> fluid_solvers() {
  static const std::initializer_list<Variant<FluidSolver>> table = {
#include "fluid_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::string default_fluid_solver() { return default_variant(fluid_solvers(), "pbf"); }
std::string default_fluid_neighbors() { return default_variant(neighbor_searches(), "grid"); }

std::string default_fluid_kernel() {
  std::string first;
  for (const Kernel& k : kernels()) {
    if (!k.sweeps) continue;  // a part of other kernels only
    if (std::string_view(k.name) == "cubic") return k.name;
    if (first.empty()) first = k.name;
  }
  return first;
}

}  // namespace feder
