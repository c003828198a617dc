// A hierarchy of axis-aligned boxes over a fixed set of items (triangles, edges): built once by halving along the
// longest side, refitted when the items move, built anew when the refitted tree has grown loose. Answers come in
// ascending order of the tree's leaves, the same for any thread count.
#pragma once
#include <span>

#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

// Contract, checked against all pairs by tests/bounds/test_box_tree.cpp: query and pairs give exactly the overlapping
// items (closed boxes), each once. Allocates only when items outnumber every earlier call.
class BoxTree {
 public:
  explicit BoxTree(Arena& a) : nodes_(&a), items_(&a), sort_(&a) {}

  void build(std::span<const Aabb> boxes);
  // The same items in new places; builds anew when the tree's surface has grown by half.
  void refit(std::span<const Aabb> boxes);
  // The items in the order of the leaves, ascending within each. An owner who stores its items in that order, with
  // boxes to match, calls number_in_order: item k is the k-th from then on, and visits are ascending.
  std::span<const std::uint32_t> order() const { return {items_.data(), items_.size()}; }
  void number_in_order(std::span<const Aabb> boxes);
  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  Aabb bounds() const { return nodes_.empty() ? Aabb{} : nodes_[0].box; }

  // visit(item) for the items whose box overlaps `box`; in the second form only those with a number of `least` or more,
  // in the same order.
  template <class F>
  void query(const Aabb& box, F&& visit) const {
    query(box, 0, visit);
  }
  template <class F>
  void query(const Aabb& box, std::uint32_t least, F&& visit) const {
    descend([&](const Node& n) { return n.last >= least && overlaps(n.box, box); },
            [&](std::uint32_t item) {
              if (item >= least && overlaps(boxes_[item], box)) visit(item);
            });
  }
  // visit(item) for all items below nodes whose boxes pass test(box); the items' own boxes are not asked.
  template <class Test, class F>
  void query_if(Test&& test, F&& visit) const {
    descend([&](const Node& n) { return test(n.box); }, visit);
  }

 private:
  static constexpr std::uint32_t kLeaf = 4;
  static constexpr int kDepth = 64;
  struct Node {
    Aabb box;
    std::uint32_t first = 0;  // leaf: in items_; else the first of two children
    std::uint32_t count = 0;  // leaf: items; else 0
    std::uint32_t last = 0;   // largest item below
  };
  struct Middle {  // of an item's box
    Real at[3];
    std::uint32_t item;
  };
  template <class Test, class F>
  void descend(Test&& test, F&& visit) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kDepth];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      if (!test(n)) continue;
      if (n.count > 0) {
        for (std::uint32_t k = n.first; k < n.first + n.count; ++k) visit(items_[k]);
        continue;
      }
      stack[top++] = n.first + 1;
      stack[top++] = n.first;
    }
  }
  void split(std::uint32_t node);
  void find_last();
  void fit();
  Real cost() const;

  Array<Node> nodes_;
  Array<std::uint32_t> items_;
  Array<Middle> sort_;  // in the order of items_
  std::span<const Aabb> boxes_;
  Real built_cost_ = 0;
};

}  // namespace feder
