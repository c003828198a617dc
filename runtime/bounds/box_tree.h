// A hierarchy of axis-aligned boxes over a fixed set of items (triangles, edges): built once by halving along the
// longest side, refitted when the items move, built anew when the refitted tree has grown loose. Answers come in
// ascending order of the tree's leaves, the same for any thread count.
#pragma once
#include <span>

#include "base/arena.h"
#include "geom/aabb.h"

namespace feder {

// Contract, checked against all pairs by tests/bounds/test_box_tree.cpp: query and pairs give exactly the overlapping
// items (closed boxes), each once. Allocates only when items outnumber every earlier call.
class BoxTree {
 public:
  explicit BoxTree(Arena& a) : nodes_(&a), items_(&a), sort_(&a) {}

  void build(std::span<const Aabb> boxes);
  // The same items in new places; builds anew when the tree's surface has grown by half.
  void refit(std::span<const Aabb> boxes);
  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  Aabb bounds() const { return nodes_.empty() ? Aabb{} : nodes_[0].box; }

  // visit(item) for the items whose box overlaps `box`.
  template <class F>
  void query(const Aabb& box, F&& visit) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kDepth];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      if (!overlaps(n.box, box)) continue;
      if (n.count > 0) {
        for (std::uint32_t k = n.first; k < n.first + n.count; ++k)
          if (overlaps(boxes_[items_[k]], box)) visit(items_[k]);
        continue;
      }
      stack[top++] = n.first + 1;
      stack[top++] = n.first;
    }
  }

 private:
  static constexpr std::uint32_t kLeaf = 4;
  static constexpr int kDepth = 64;
  struct Node {
    Aabb box;
    std::uint32_t first = 0;  // leaf: in items_; else the first of two children
    std::uint32_t count = 0;  // leaf: items; else 0
  };
  void split(std::uint32_t node);
  void fit();
  Real cost() const;

  Array<Node> nodes_;
  Array<std::uint32_t> items_;
  Array<Vec3> sort_;  // middles
  std::span<const Aabb> boxes_;
  Real built_cost_ = 0;
};

}  // namespace feder
