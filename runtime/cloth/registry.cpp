#include "cloth/solver.h"

namespace feder {
using Row = Variant<ClothSolver>;
#include "cloth_declare.inc"

std::span<const Variant<ClothSolver>> cloth_solvers() {
  static const Row rows[] = {
#include "cloth_rows.inc"
  };
  return rows;
}

}  // namespace feder
