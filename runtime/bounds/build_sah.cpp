// Surface area heuristic: of the splits between 16 bins along each axis, the one with the least sum of surface times
// items, that is of what a random query costs. Where all middles lie in one bin: the median of the order.
// Weak spot: the heuristic knows rays, not boxes as large as the items. Source: Wald, "On fast Construction of
// SAH-based Bounding Volume Hierarchies", RT 2007.
#include <algorithm>

#include "bounds/tree_build.h"

namespace feder {
namespace {

constexpr int kBins = 16;

struct Bin {
  Aabb box;
  std::uint32_t count = 0;
  void add(const Bin& b) { box.include(b.box), count += b.count; }
  double cost() const { return count == 0 ? 0 : count * half_surface(box); }
};

int bin_of(Real at, Real from, Real size) {
  const Real place = (at - from) / size * kBins;
  return place < kBins ? static_cast<int>(place) : kBins - 1;
}

}  // namespace

TreeBuild bounds_sah() {
  return {"sah", "splits by the surface area heuristic, in 16 bins",
          [](std::span<const Aabb> boxes, std::uint32_t leaf) {
            return build_by_splits(static_cast<std::uint32_t>(boxes.size()), leaf,
                                   [&](std::vector<std::uint32_t>& order, std::uint32_t first, std::uint32_t last) {
                                     Aabb spread;
                                     for (std::uint32_t k = first; k < last; ++k)
                                       spread.include(middle_of(boxes[order[k]]));
                                     double least = 1e300;
                                     int best_axis = -1, best_bin = 0;
                                     for (int axis = 0; axis < 3; ++axis) {
                                       const Real from = spread.lo[axis], size = spread.hi[axis] - from;
                                       if (!(size > 0)) continue;
                                       Bin bins[kBins], right[kBins];
                                       for (std::uint32_t k = first; k < last; ++k) {
                                         const Aabb& box = boxes[order[k]];
                                         bins[bin_of(middle_of(box)[axis], from, size)].add({box, 1});
                                       }
                                       right[kBins - 1] = bins[kBins - 1];
                                       for (int b = kBins - 2; b > 0; --b)
                                         right[b] = right[b + 1], right[b].add(bins[b]);
                                       Bin left;
                                       for (int b = 1; b < kBins; ++b) {
                                         left.add(bins[b - 1]);
                                         const double cost = left.cost() + right[b].cost();
                                         if (left.count == 0 || right[b].count == 0 || !(cost < least)) continue;
                                         least = cost, best_axis = axis, best_bin = b;
                                       }
                                     }
                                     if (best_axis < 0) return first;
                                     const Real from = spread.lo[best_axis], size = spread.hi[best_axis] - from;
                                     const auto middle = std::stable_partition(
                                         order.begin() + first, order.begin() + last, [&](std::uint32_t i) {
                                           return bin_of(middle_of(boxes[i])[best_axis], from, size) < best_bin;
                                         });
                                     return static_cast<std::uint32_t>(middle - order.begin());
                                   });
          }};
}

}  // namespace feder
