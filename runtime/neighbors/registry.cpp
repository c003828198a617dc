// The table of neighbour searches, generated from the feder_variant(neighbors ...) lines.
#include "neighbors/neighbor_search.h"

namespace feder {

using Row = Variant<NeighborSearch>;
#include "neighbors_declare.inc"

std::span<const Variant<NeighborSearch>> neighbor_searches() {
  static const std::initializer_list<Variant<NeighborSearch>> table = {
#include "neighbors_rows.inc"
  };
  return {table.begin(), table.size()};
}

}  // namespace feder
