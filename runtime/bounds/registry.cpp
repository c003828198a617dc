// The tables of volumes, of builds and of searches, generated from the feder_variant(bounds ...) lines.
#include "bounds/box_search.h"
#include "bounds/volume.h"
#include "feder/error.h"
#include "feder/params.h"

namespace feder {

using Row = VolumeKind;
#include "bounds_declare.inc"
using RowOfbuilds = TreeBuild;
#include "bounds_builds_declare.inc"
using RowOfsearches = Variant<BoxSearch>;
#include "bounds_searches_declare.inc"

std::span<const VolumeKind> bounding_volumes() {
  static const std::initializer_list<VolumeKind> table = {
#include "bounds_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::span<const TreeBuild> tree_builds() {
  static const std::initializer_list<TreeBuild> table = {
#include "bounds_builds_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::span<const Variant<BoxSearch>> box_searches() {
  static const std::initializer_list<Variant<BoxSearch>> table = {
#include "bounds_searches_rows.inc"
  };
  return {table.begin(), table.size()};
}
std::string default_box_search() { return std::string(default_variant(box_searches(), "swept_boxes")); }

const VolumeKind& bounding_volume(std::string_view name) {
  return find_variant(bounding_volumes(), name, "bounding volume");
}
const TreeBuild& tree_build(std::string_view name) { return find_variant(tree_builds(), name, "build"); }

void check_finite(ItemPoints items) {
  for (std::size_t i = 0; i < items.points.size(); ++i)
    if (!is_finite(items.points[i]))
      throw SceneError("hierarchy: expected finite points, but those of item " + std::to_string(i / items.each + 1) +
                       " are not");
}

void fail_empty_volume() { throw SceneError("bounding volume: expected at least one point, got none"); }

}  // namespace feder
