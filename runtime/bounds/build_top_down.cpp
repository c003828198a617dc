// Top-down by the median: items are ordered by their middles along the axis on which those spread most, and halved.
// Weak spot: what lies far apart on one side of the median shares a node. Source: Ericson, "Real-Time Collision
// Detection" (2005), 6.2.
#include <algorithm>

#include "bounds/tree_build.h"

namespace feder {

TreeBuild bounds_top_down() {
  return {"top_down", "halves at the median of the longest axis", [](std::span<const Aabb> boxes, std::uint32_t leaf) {
            return build_by_splits(
                static_cast<std::uint32_t>(boxes.size()), leaf,
                [&](std::vector<std::uint32_t>& order, std::uint32_t first, std::uint32_t last) {
                  Aabb spread;
                  for (std::uint32_t k = first; k < last; ++k) spread.include(middle_of(boxes[order[k]]));
                  const Vec3 size = spread.hi - spread.lo;
                  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
                  const std::uint32_t half = first + (last - first) / 2;
                  std::sort(order.begin() + first, order.begin() + last, [&](std::uint32_t a, std::uint32_t b) {
                    const Real x = middle_of(boxes[a])[axis], y = middle_of(boxes[b])[axis];
                    return x != y ? x < y : a < b;
                  });
                  return half;
                });
          }};
}

}  // namespace feder
