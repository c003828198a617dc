// The table of force kinds, generated from the feder_variant(forces ...) lines.
#include "feder/force.h"

namespace feder {

using Row = Variant<Force>;
#include "forces_declare.inc"

std::span<const Variant<Force>> force_kinds() {
  static const std::initializer_list<Variant<Force>> table = {
#include "forces_rows.inc"
  };
  return {table.begin(), table.size()};
}

}  // namespace feder
