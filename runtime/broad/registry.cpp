// The table of broad phases, generated from the feder_variant(broad ...) lines.
#include "broad/broad_phase.h"

namespace feder {

using Row = Variant<BroadPhase>;
#include "broad_declare.inc"

std::span<const Variant<BroadPhase>> broad_phases() {
  static const std::initializer_list<Variant<BroadPhase>> table = {
#include "broad_rows.inc"
  };
  return {table.begin(), table.size()};
}

}  // namespace feder
