// The table of pair tests, generated from the feder_pair lines.
#include "narrow/narrow_phase.h"

namespace feder {

using Row = PairRow;
#include "narrow_declare.inc"

std::span<const PairRow> pair_tests() {
  static const std::initializer_list<PairRow> table = {
#include "narrow_rows.inc"
  };
  return {table.begin(), table.size()};
}

}  // namespace feder
