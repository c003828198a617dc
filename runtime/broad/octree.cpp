// A loose octree: a box lies in the node of its middle at the deepest level whose cells are not smaller than it; the
// node's bounds are what its boxes fill of that cell, grown by half a cell on every side. Axes along which all middles
// are the same are not halved: what lies in a plane gets a quadtree. Source: Ulrich, "Loose Octrees", in Game
// Programming Gems (2000). Nodes are made by sorting Morton codes, so all below a node is one run.
// Kept between calls: memory. Weak spot: boxes that are large beside their spread all lie at the root.
#include "bounds/box_query.h"
#include "bounds/morton_order.h"
#include "broad/rebuilt.h"

namespace feder {
namespace {

class OctreeIndex {
 public:
  explicit OctreeIndex(Arena& a) : nodes_(&a), sort_(&a), item_(&a), boxes_(&a) {}

  void build(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed, JobPool&) {
    nodes_.clear(), sort_.clear();
    place_root(boxes, listed);
    for (const std::uint32_t i : listed) sort_.push_back(placed(boxes[i], i));
    std::sort(sort_.begin(), sort_.end());
    item_.resize(sort_.size()), boxes_.resize(sort_.size());
    for (std::size_t k = 0; k < sort_.size(); ++k) item_[k] = sort_[k].item, boxes_[k] = boxes[item_[k]];
    if (sort_.empty()) return;
    nodes_.reserve(2 * sort_.size());
    nodes_.push_back({Aabb(), 0, static_cast<std::uint32_t>(sort_.size()), 0, 0, 0, 0});
    for (std::uint32_t n = 0; n < nodes_.size(); ++n) split(n);
    for (std::size_t n = nodes_.size(); n-- > 0;) {  // children come after their parents
      Node& node = nodes_[n];
      for (std::uint32_t k = node.first; k < node.own; ++k) node.bounds.include(boxes_[k]);
      for (std::uint32_t k = 0; k < node.children; ++k) node.bounds.include(nodes_[node.child + k].bounds);
    }
  }

  template <class F, class W>
  void query(const Aabb& box, F&& visit, W& work) const {
    const BoxQuery wanted(box);
    descend(
        [&](const Aabb& bounds) {
          work.visit();
          return wanted.meets(bounds);
        },
        [&](std::uint32_t k) {
          work.test();
          if (wanted.meets(boxes_[k])) visit(item_[k]);
        });
  }
  template <class F>
  void query_ray(const Vec3& origin, const Vec3& ray, F&& visit) const {
    descend([&](const Aabb& bounds) { return segment_hits(bounds, origin, ray); },
            [&](std::uint32_t k) { visit(item_[k]); });
  }
  template <class F>
  bool cells_at(int level, F&& draw) const {
    return !nodes_.empty() && nodes_below(0, level, draw);
  }

 private:
  static constexpr std::uint32_t kDeepest = 20, kFew = 8;
  struct Placed {
    std::uint64_t code;  // of the cell, the bits below its level 0
    std::uint32_t level, item;
    friend auto operator<=>(const Placed&, const Placed&) = default;
  };
  struct Node {
    Aabb bounds;
    std::uint32_t first, end;       // all at and below it
    std::uint32_t own;              // those at it end there; all of them for a leaf
    std::uint32_t child, children;  // in nodes_
    std::uint32_t level;
  };

  void place_root(const Array<Aabb>& boxes, const Array<std::uint32_t>& listed) {
    double hi[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      root_lo_[k] = hi[k] = 0;
      bool first = true;
      for (const std::uint32_t i : listed) {
        const double c = middle(boxes[i], k);
        root_lo_[k] = first ? c : std::fmin(root_lo_[k], c), hi[k] = first ? c : std::fmax(hi[k], c);
        first = false;
      }
    }
    width_ = 0;
    for (int k = 0; k < 3; ++k) width_ = std::fmax(width_, hi[k] - root_lo_[k]);
    for (int k = 0; k < 3; ++k) halved_[k] = hi[k] > root_lo_[k];
  }
  static double middle(const Aabb& b, int k) {
    return 0.5 * (static_cast<double>(b.lo[k]) + static_cast<double>(b.hi[k]));
  }

  Placed placed(const Aabb& b, std::uint32_t item) const {
    double side = 0;
    for (int k = 0; k < 3; ++k)
      if (halved_[k]) side = std::fmax(side, static_cast<double>(b.hi[k]) - static_cast<double>(b.lo[k]));
    std::uint32_t level = 0;
    for (double cell = width_ / 2; level < kDeepest && cell >= side && cell > 0; cell /= 2) ++level;
    std::uint64_t code = 0;
    constexpr std::uint32_t kCells = 1u << kDeepest;
    for (int k = 0; k < 3; ++k) {
      if (!halved_[k]) continue;
      const double at = (middle(b, k) - root_lo_[k]) / width_ * kCells;
      const std::uint32_t cell = std::min(static_cast<std::uint32_t>(std::fmax(at, 0)), kCells - 1);
      code |= spread_bits(cell >> (kDeepest - level) << (kDeepest - level)) << (2 - k);
    }
    return {code, level, item};
  }

  // Where no children follow: what is at deeper levels of few boxes counts as at the node.
  void split(std::uint32_t n) {
    Node node = nodes_[n];
    node.own = node.first;
    while (node.own < node.end && sort_[node.own].level == node.level) ++node.own;
    if (node.end - node.first <= kFew) node.own = node.end;
    node.child = static_cast<std::uint32_t>(nodes_.size());
    const auto below = [&](std::uint32_t level) { return 3 * (kDeepest - level) - 3; };  // bits below a child's
    // an empty node with one child is skipped, so there are less than twice as many nodes as boxes
    while (node.own == node.first &&
           sort_[node.first].code >> below(node.level) == sort_[node.end - 1].code >> below(node.level)) {
      ++node.level;
      while (node.own < node.end && sort_[node.own].level == node.level) ++node.own;
    }
    const std::uint32_t shift = node.own < node.end ? below(node.level) : 0;
    for (std::uint32_t k = node.own; k < node.end;) {
      const std::uint64_t octant = sort_[k].code >> shift;
      std::uint32_t end = k;
      while (end < node.end && sort_[end].code >> shift == octant) ++end;
      nodes_.push_back({Aabb(), k, end, 0, 0, 0, node.level + 1});
      k = end;
    }
    node.children = static_cast<std::uint32_t>(nodes_.size()) - node.child;
    nodes_[n] = node;
  }

  template <class F>
  bool nodes_below(std::uint32_t at, int level, F& draw) const {
    const Node& n = nodes_[at];
    if (level == 0 || n.children == 0) return draw(n.bounds), n.children > 0;
    bool deeper = false;
    for (std::uint32_t k = 0; k < n.children; ++k) deeper = nodes_below(n.child + k, level - 1, draw) || deeper;
    return deeper;
  }

  template <class Test, class F>
  void descend(Test&& test, F&& visit) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[8 * (kDeepest + 1)];  // up to seven wait at each level
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      if (!test(n.bounds)) continue;
      for (std::uint32_t k = n.first; k < n.own; ++k) visit(k);
      for (std::uint32_t k = n.children; k-- > 0;) stack[top++] = n.child + k;
    }
  }

  Array<Node> nodes_;
  Array<Placed> sort_;
  Array<std::uint32_t> item_;                  // in that order
  Array<Aabb> boxes_;                          // theirs
  double root_lo_[3] = {0, 0, 0}, width_ = 0;  // m
  bool halved_[3] = {true, true, true};
};

}  // namespace

Variant<BroadPhase> broad_octree() {
  return variant_of<BroadPhase, RebuiltPhase<OctreeIndex>>("octree", "a loose octree; a quadtree in a plane");
}

}  // namespace feder
