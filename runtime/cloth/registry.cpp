// The table of cloth solvers, from the lines that feder_variant(cloth ...) wrote.
#include "cloth/solver.h"
#include "feder/cloth.h"

namespace feder {
using Row = Variant<ClothSolver>;
#include "cloth_declare.inc"

std::span<const Variant<ClothSolver>> cloth_solvers() {
  static const std::initializer_list<Row> rows = {
#include "cloth_rows.inc"
  };
  return {rows.begin(), rows.size()};
}

std::string default_cloth_solver() { return default_variant(cloth_solvers(), "xpbd"); }

}  // namespace feder
