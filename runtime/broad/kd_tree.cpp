// A kd-tree of boxes: each node halves its boxes by their middles along its longest side, and keeps how far the boxes
// of the lower half reach up and those of the upper half reach down, as they overlap. Sources: Bentley,
// "Multidimensional binary search trees used for associative searching" (1975); Ooi, McDonell & Sacks-Davis, "Spatial
// kd-tree" (1987), for boxes.
// Kept between calls: memory. Weak spot: a box that is large beside its neighbours widens all nodes above it.
#include <limits>

#include "bounds/box_query.h"
#include "bounds/middles.h"
#include "broad/rebuilt.h"

namespace feder {
namespace {

class KdTreeIndex {
 public:
  explicit KdTreeIndex(Arena& a) : nodes_(&a), sort_(&a), item_(&a), boxes_(&a) {}

  void build(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed, JobPool&) {
    nodes_.clear(), sort_.clear();
    for (const std::uint32_t i : listed) {
      const Vec3 c = Real(0.5) * (boxes[i].lo + boxes[i].hi);
      sort_.push_back({{c[0], c[1], c[2]}, i});
    }
    if (!sort_.empty()) nodes_.push_back({0, 0, 0, static_cast<std::uint32_t>(sort_.size()), kLeafAxis});
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) split(n, boxes);
    item_.resize(sort_.size()), boxes_.resize(sort_.size());
    for (std::size_t k = 0; k < sort_.size(); ++k) item_[k] = sort_[k].item, boxes_[k] = boxes[item_[k]];
  }

  template <class F, class W>
  void query(const Aabb& box, F&& visit, W& work) const {
    if (nodes_.empty()) return;
    const BoxQuery wanted(box);
    std::uint32_t stack[kDepth];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      work.visit();
      if (n.axis == kLeafAxis) {
        work.test(n.end - n.first);
        for (std::uint32_t k = n.first; k < n.end; ++k)
          if (wanted.meets(boxes_[k])) visit(item_[k]);
        continue;
      }
      if (box.hi[n.axis] >= n.upper_from) stack[top++] = n.first + 1;
      if (box.lo[n.axis] <= n.lower_to) stack[top++] = n.first;
    }
  }

  template <class F>
  void query_ray(const Vec3& origin, const Vec3& ray, F&& visit) const {
    struct Part {
      std::uint32_t node;
      double from, to;  // of the segment
    };
    if (nodes_.empty()) return;
    Part stack[kDepth];
    int top = 0;
    stack[top++] = {0, 0, 1};
    while (top > 0) {
      const Part p = stack[--top];
      const Node& n = nodes_[p.node];
      if (n.axis == kLeafAxis) {
        for (std::uint32_t k = n.first; k < n.end; ++k) visit(item_[k]);
        continue;
      }
      // the test of a box rounds like Real
      const double o = origin[n.axis], r = ray[n.axis], lower = n.lower_to, upper = n.upper_from;
      const double rounding = 8 * static_cast<double>(std::numeric_limits<Real>::epsilon()),
                   slack = rounding * (std::fabs(o) + std::fabs(r) + std::fmax(std::fabs(lower), std::fabs(upper)));
      Part low = p, high = p;
      low.node = n.first, high.node = n.first + 1;
      clip(o, r, lower + slack, low.from, low.to);
      clip(-o, -r, -upper + slack, high.from, high.to);
      if (high.from <= high.to) stack[top++] = high;
      if (low.from <= low.to) stack[top++] = low;
    }
  }

  template <class F>
  bool cells_at(int level, F&& draw) const {
    return !nodes_.empty() && nodes_below(0, level, draw);
  }

 private:
  static constexpr std::uint32_t kLeaf = 8;
  static constexpr std::int32_t kLeafAxis = 3;
  static constexpr int kDepth = 64;
  struct Node {
    Real lower_to = 0, upper_from = 0;  // along the axis, m
    std::uint32_t first = 0, end = 0;   // leaf: its boxes; else first: of two children
    std::int32_t axis = kLeafAxis;
  };

  // What of the times from .. to has o + t r <= most.
  static void clip(double o, double r, double most, double& from, double& to) {
    if (r > 0)
      to = std::fmin(to, (most - o) / r);
    else if (r < 0)
      from = std::fmax(from, (most - o) / r);
    else if (o > most)
      to = -1;
  }

  Aabb bounds_of(std::uint32_t node) const {
    const Node& n = nodes_[node];
    Aabb all;
    if (n.axis != kLeafAxis) {
      all = bounds_of(n.first), all.include(bounds_of(n.first + 1));
      return all;
    }
    for (std::uint32_t k = n.first; k < n.end; ++k) all.include(boxes_[k]);
    return all;
  }
  template <class F>
  bool nodes_below(std::uint32_t at, int level, F& draw) const {
    const Node& n = nodes_[at];
    if (level == 0 || n.axis == kLeafAxis) return draw(bounds_of(at)), n.axis != kLeafAxis;
    const bool first = nodes_below(n.first, level - 1, draw);
    return nodes_below(n.first + 1, level - 1, draw) || first;
  }

  void split(std::uint32_t node, const Array<Aabb>& boxes) {
    const std::uint32_t first = nodes_[node].first, end = nodes_[node].end;
    if (end - first <= kLeaf) return;
    const std::uint32_t half = first + (end - first) / 2;
    const int axis = divide_middles({sort_.data() + first, end - first}, half - first);
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({0, 0, first, half, kLeafAxis}), nodes_.push_back({0, 0, half, end, kLeafAxis});
    Node& n = nodes_[node];
    n.axis = axis, n.first = child, n.lower_to = -kInfinity, n.upper_from = kInfinity;
    for (std::uint32_t k = first; k < half; ++k) n.lower_to = std::max(n.lower_to, boxes[sort_[k].item].hi[axis]);
    for (std::uint32_t k = half; k < end; ++k) n.upper_from = std::min(n.upper_from, boxes[sort_[k].item].lo[axis]);
  }

  Array<Node> nodes_;  // children lie side by side after their parent
  Array<BoxMiddle> sort_;
  Array<std::uint32_t> item_;  // in the order of the leaves
  Array<Aabb> boxes_;          // theirs
};

}  // namespace

Variant<BroadPhase> broad_kd_tree() {
  return variant_of<BroadPhase, RebuiltPhase<KdTreeIndex>>("kd_tree", "boxes halved by their middles, again and again");
}

}  // namespace feder
