// The tables of shape kinds and of indices of meshes, generated from the feder_variant(geom ...) lines.
#include <algorithm>
#include <cstring>

#include "bounds/volume.h"
#include "feder/error.h"
#include "feder/params.h"
#include "feder/shape.h"
#include "geom/mesh_index.h"

namespace feder {

using Row = ShapeKind;
#include "geom_declare.inc"
using RowOfindexes = TriangleIndexKind;
#include "geom_indexes_declare.inc"

std::span<const ShapeKind> shape_kinds() {
  static const std::initializer_list<ShapeKind> table = {
#include "geom_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::span<const TriangleIndexKind> triangle_indexes() {
  static const std::initializer_list<TriangleIndexKind> table = {
#include "geom_indexes_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::string mesh_index_names() { return variant_names(triangle_indexes()); }
std::string bounding_volume_names() { return variant_names(bounding_volumes()); }
std::string tree_build_names() { return variant_names(tree_builds()); }

int shape_kind_id(const char* name) {
  int id = 0;
  for (const ShapeKind& kind : shape_kinds()) {
    if (!std::strcmp(kind.name, name)) return id;
    ++id;
  }
  throw SceneError(std::string("shape: this build has no ") + name);
}

ShapePtr make_shape(const char* kind, const ShapeInput& input) {
  return shape_kinds()[static_cast<std::size_t>(shape_kind_id(kind))].make(input);
}

int any_convex_kind() {
  static const int id = [] {
    const auto kinds = shape_kinds();
    const auto found = std::find_if(kinds.begin(), kinds.end(), [](const ShapeKind& kind) { return kind.any_convex; });
    return found == kinds.end() ? -1 : static_cast<int>(found - kinds.begin());
  }();
  if (id < 0) throw SceneError("shape: this build has no kind for convex shapes that are made on the fly");
  return id;
}

}  // namespace feder
