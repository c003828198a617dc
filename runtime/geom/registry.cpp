// The table of shape kinds, generated from the feder_variant(geom ...) lines.
#include <cstring>

#include "base/error.h"
#include "geom/shape.h"

namespace feder {

using Row = ShapeKind;
#include "geom_declare.inc"

std::span<const ShapeKind> shape_kinds() {
  static const std::initializer_list<ShapeKind> table = {
#include "geom_rows.inc"
  };
  return {table.begin(), table.size()};
}

int shape_kind_id(const char* name) {
  int id = 0;
  for (const ShapeKind& kind : shape_kinds()) {
    if (!std::strcmp(kind.name, name)) return id;
    ++id;
  }
  throw SceneError(std::string("shape kind '") + name + "' is left out of this build");
}

}  // namespace feder
