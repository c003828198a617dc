// Bottom-up, agglomerative: pairs that are each other's nearest, by the surface of their common box, become one, until
// one is left. The nearest is looked for among the neighbours in Morton order, 16 on either side, so it takes n log n
// where all pairs would take n^2. Its trees need the fewest tests (tests/README.md). Weak spot: slow to build.
// Sources: Walter et al., "Fast Agglomerative Clustering for Rendering", RT 2008; Meister & Bittner, "Parallel
// Locally-Ordered Clustering for Bounding Volume Hierarchy Construction", TVCG 2018.
#include "bounds/morton_order.h"

namespace feder {
namespace {

constexpr std::size_t kWindow = 16;

struct Cluster {
  Aabb box;
  std::uint32_t link;
};

// By what it would cost, then by place: a total order, so one pair at least is mutual.
std::size_t nearest_to(const std::vector<Cluster>& list, std::size_t i) {
  const std::size_t from = i > kWindow ? i - kWindow : 0, to = std::min(list.size(), i + kWindow + 1);
  std::size_t best = i;
  double least = 1e300;
  const auto before = [i](std::size_t a, std::size_t b) {  // of two pairs with i
    return std::minmax(a, i) < std::minmax(b, i);
  };
  for (std::size_t k = from; k < to; ++k) {
    if (k == i) continue;
    Aabb both = list[i].box;
    both.include(list[k].box);
    const double cost = half_surface(both);
    if (best == i || cost < least || (cost == least && before(k, best))) least = cost, best = k;
  }
  return best;
}

}  // namespace

TreeBuild bounds_bottom_up() {
  return {"bottom_up", "joins what is nearest: fewest tests of volumes",
          [](std::span<const Aabb> boxes, std::uint32_t leaf) {
            std::vector<TreeLink> links;
            std::vector<Cluster> list, next;
            for (const MortonItem& m : morton_order(boxes)) {
              list.push_back({boxes[m.item], static_cast<std::uint32_t>(links.size())});
              links.push_back({{kNone, kNone}, m.item});
            }
            std::vector<std::size_t> nearest;
            while (list.size() > 1) {
              nearest.clear(), next.clear();
              for (std::size_t i = 0; i < list.size(); ++i) nearest.push_back(nearest_to(list, i));
              for (std::size_t i = 0; i < list.size(); ++i) {
                const std::size_t k = nearest[i];
                if (nearest[k] != i) {
                  next.push_back(list[i]);
                } else if (i < k) {
                  Cluster both = list[i];
                  both.box.include(list[k].box);
                  both.link = static_cast<std::uint32_t>(links.size());
                  links.push_back({{list[i].link, list[k].link}, kNone});
                  next.push_back(both);
                }
              }
              list.swap(next);
            }
            return shape_of_links(links, list.empty() ? kNone : list[0].link, leaf);
          }};
}

}  // namespace feder
