// Linear build: items in Morton order, split where the highest bit of their codes changes; equal codes are halved.
// One sort is all that it takes. Weak spot: cells of the curve know no surfaces: the most tests of volumes
// (tests/README.md).
// Source: Lauterbach et al., "Fast BVH Construction on GPUs", Eurographics 2009.
#include <bit>

#include "bounds/morton_order.h"

namespace feder {

TreeBuild bounds_morton() {
  return {"morton", "splits along the Morton curve: one sort", [](std::span<const Aabb> boxes, std::uint32_t leaf) {
            const std::vector<MortonItem> list = morton_order(boxes);
            TreeShape tree = build_by_splits(
                static_cast<std::uint32_t>(boxes.size()), leaf,
                [&](std::vector<std::uint32_t>&, std::uint32_t first, std::uint32_t last) {
                  const std::uint64_t change = list[first].code ^ list[last - 1].code;
                  if (change == 0) return first;
                  const std::uint64_t bit = std::uint64_t(1) << (std::bit_width(change) - 1);
                  const auto middle = std::partition_point(list.begin() + first, list.begin() + last,
                                                           [bit](const MortonItem& m) { return !(m.code & bit); });
                  return static_cast<std::uint32_t>(middle - list.begin());
                });
            for (std::uint32_t k = 0; k < tree.order.size(); ++k) tree.order[k] = list[k].item;
            return tree;
          }};
}

}  // namespace feder
