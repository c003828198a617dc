// The tables of pair tests and of methods, generated from the feder_pair and feder_variant lines.
#include "narrow/narrow_phase.h"

namespace feder {

using Row = PairRow;
#include "narrow_declare.inc"
using RowOfmethods = NarrowMethod;
#include "narrow_methods_declare.inc"

std::span<const PairRow> pair_tests() {
  static const std::initializer_list<PairRow> table = {
#include "narrow_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::span<const NarrowMethod> narrow_methods() {
  static const std::vector<NarrowMethod> table = {
#include "narrow_methods_rows.inc"
  };
  return table;
}

}  // namespace feder
