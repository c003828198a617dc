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

std::string default_fluid_solver() { return default_variant(fluid_solvers(), "dfsph"); }
std::string default_fluid_neighbors() { return default_variant(neighbor_searches(), "grid"); }

// Particles of the other solvers lie too close together at the surface: the colour field would have no tension there.
std::string default_surface_model(std::string_view solver) { return solver == "dfsph" ? "color_field" : "cohesion"; }

// With the cubic spline waves of dfsph swing 1 % too fast; the others were measured with it.
std::string default_fluid_kernel(std::string_view solver) {
  const std::string_view wanted = solver == "dfsph" ? "wendland" : "cubic";
  std::string first;
  for (const Kernel& k : kernels()) {
    if (!k.sweeps) continue;  // a part of other kernels only
    if (wanted == k.name) return k.name;
    if (first.empty()) first = k.name;
  }
  return first;
}

}  // namespace feder
