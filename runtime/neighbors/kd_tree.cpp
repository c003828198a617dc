// kd-tree: points split at the median of the longest side down to leaves of eight, built anew in each call.
// Source: Bentley, "Multidimensional binary search trees used for associative searching", CACM 1975.
// Kept between calls: work arrays. Weak spot: building costs O(n log n) on one thread; at a fixed radius the grid wins.
#include "neighbors/rows.h"

namespace feder {
namespace {

constexpr std::uint32_t kLeaf = 8;

struct Node {
  Real lo[3], hi[3];
  std::uint32_t first = 0, count = 0;  // in order_
  std::uint32_t right = 0;             // 0: a leaf; the left child follows its parent
};

class KdTree final : public NeighborSearch {
 public:
  explicit KdTree(Arena& a) : order_(&a), nodes_(&a) {}

  void find(std::span<const Real> p, Real radius, JobPool& jobs, NeighborLists& out) override {
    const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
    order_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) order_[i] = i;
    nodes_.clear();
    if (count > 0) build(p, 0, count);
    const Real near = radius * radius;
    fill_rows(count, jobs, out, false, [&](std::uint32_t i, auto& sink, int) {
      const Real* x = &p[4 * std::size_t(i)];
      std::uint32_t stack[64], depth = 0;
      stack[depth++] = 0;
      while (depth > 0) {
        const std::uint32_t at = stack[--depth];
        const Node& node = nodes_[at];
        if (far(node, x, radius)) continue;
        if (node.right) {
          stack[depth++] = node.right, stack[depth++] = at + 1;
          continue;
        }
        for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
          const std::uint32_t j = order_[k];
          const Real* q = &p[4 * std::size_t(j)];
          const Real dx = q[0] - x[0], dy = q[1] - x[1], dz = q[2] - x[2];
          sink.take(j, (dx * dx + dy * dy + dz * dz < near) & (j != i));
        }
      }
    });
  }

 private:
  static bool far(const Node& n, const Real* x, Real radius) {
    for (int k = 0; k < 3; ++k)
      if (x[k] + radius < n.lo[k] || x[k] - radius > n.hi[k]) return true;
    return false;
  }

  std::uint32_t build(std::span<const Real> p, std::uint32_t first, std::uint32_t count) {
    const std::uint32_t at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Node n;
    n.first = first, n.count = count;
    int axis = 0;
    for (int k = 0; k < 3; ++k) {
      n.lo[k] = n.hi[k] = p[4 * std::size_t(order_[first]) + static_cast<std::size_t>(k)];
      for (std::uint32_t i = first + 1; i < first + count; ++i) {
        const Real x = p[4 * std::size_t(order_[i]) + static_cast<std::size_t>(k)];
        n.lo[k] = std::min(n.lo[k], x), n.hi[k] = std::max(n.hi[k], x);
      }
      if (n.hi[k] - n.lo[k] > n.hi[axis] - n.lo[axis]) axis = k;
    }
    if (count > kLeaf) {
      const std::uint32_t half = count / 2;
      const auto begin = order_.begin() + first;
      std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        const Real xa = p[4 * std::size_t(a) + static_cast<std::size_t>(axis)];
        const Real xb = p[4 * std::size_t(b) + static_cast<std::size_t>(axis)];
        return xa != xb ? xa < xb : a < b;
      });
      build(p, first, half);
      n.right = build(p, first + half, count - half);
    }
    nodes_[at] = n;
    return at;
  }

  Array<std::uint32_t> order_;
  Array<Node> nodes_;
};

}  // namespace

Variant<NeighborSearch> neighbors_kd_tree() {
  return variant_of<NeighborSearch, KdTree>("kd_tree", "kd-tree, built anew each time");
}

}  // namespace feder
