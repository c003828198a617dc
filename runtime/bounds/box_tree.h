// A hierarchy of axis-aligned boxes over a fixed set of items (triangles, edges): built once by halving along the
// longest side, refitted when the items move, built anew when the refitted tree has grown loose. Queries descend two
// levels at a time, and four boxes are compared together, there as in the leaves. Answers come in ascending order of
// the tree's leaves, the same for any thread count.
#pragma once
#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "bounds/box_block.h"
#include "bounds/box_query.h"
#include "bounds/middles.h"
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

// Contract, checked against all pairs by tests/bounds/test_box_tree.cpp: query and pairs give exactly the overlapping
// items (closed boxes), each once. Allocates only when items outnumber every earlier call.
class BoxTree {
 public:
  explicit BoxTree(Arena& a) : nodes_(&a), fours_(&a), blocks_(&a), items_(&a), sort_(&a), leaves_(&a) {}

  void build(std::span<const Aabb> boxes);
  // The same items in new places; builds anew when the tree's surface has grown by half.
  void refit(std::span<const Aabb> boxes);
  // The items in the order of the leaves, ascending within each. An owner who stores its items in that order calls
  // number_in_order: item k is the k-th from then on, and visits are ascending; `pairs` needs a refit first.
  std::span<const std::uint32_t> order() const { return {items_.data(), items_.size()}; }
  void number_in_order();
  bool empty() const { return items_.empty(); }
  std::size_t size() const { return items_.size(); }
  Aabb bounds() const { return nodes_.empty() ? Aabb{} : nodes_[0].box; }

  // visit(item) for the items whose box overlaps `box`.
  template <class F>
  void query(const Aabb& box, F&& visit) const {
    if (fours_.empty()) return;
    const Around around(box);
    std::uint32_t stack[2 * kDepth];  // up to three a level, of which there are half as many
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t at = stack[--top];
      if (at & kLeafBit) {
        query_leaf(at & kFirstMask, (at >> kCountShift & (kLeaf - 1)) + 1, around, visit);
        continue;
      }
      const Four& f = fours_[at];
      for (unsigned hit = overlapping(f, around); hit != 0;) {
        const unsigned k = static_cast<unsigned>(std::bit_width(hit)) - 1;  // the last first: it waits longest
        stack[top++] = f.child[k], hit ^= 1u << k;
      }
    }
  }
  // visit(a, b) for all overlapping items a < b: by ascending a, and for each in the order of query.
  template <class F>
  void pairs(F&& visit) {
    constexpr std::uint32_t kTogether = 8;  // neighbours in number are so in space: one descent for a few of them
    const auto count = static_cast<std::uint32_t>(items_.size());
    FEDER_ASSERT(boxes_.size() == count);
    leaves_.reserve(count);
    for (std::uint32_t first = 0; first < count; first += kTogether) {
      const std::uint32_t end = std::min(first + kTogether, count);
      Aabb all;
      for (std::uint32_t a = first; a < end; ++a) all.include(boxes_[a]);
      leaves_.clear();
      const BoxQuery query(all);
      descend([&](const Node& n) { return n.last > first && query.meets(n.box); },
              [&](const Node& n) { leaves_.push_back(static_cast<std::uint32_t>(&n - nodes_.data())); });
      for (std::uint32_t a = first; a < end; ++a) {
        const Around own(boxes_[a]);
        for (const std::uint32_t leaf : leaves_)
          if (const Node& n = nodes_[leaf]; n.last > a && overlaps(n.box, boxes_[a]))
            query_leaf(n.first, n.count, own, [&](std::uint32_t b) {
              if (b > a) visit(a, b);
            });
      }
    }
  }
  // visit(item) for all items below nodes whose boxes pass test(box); the items' own boxes are not asked.
  template <class Test, class F>
  void query_if(Test&& test, F&& visit) const {
    descend([&](const Node& n) { return test(n.box); },
            [&](const Node& n) {
              for (std::uint32_t k = n.first; k < n.first + n.count; ++k) visit(items_[k]);
            });
  }
  // For drawing: visit(box) for the boxes so many levels below the root and those of leaves above, while it returns
  // true. Returns whether there are deeper ones.
  template <class F>
  bool boxes_at(int level, F&& visit) const {
    std::vector<int> depth(nodes_.size(), 0);
    bool more = true, deeper = false;
    for (std::size_t n = 0; n < depth.size(); ++n) {
      const Node& node = nodes_[n];
      if (node.count == 0) depth[node.first] = depth[node.first + 1] = depth[n] + 1;
      deeper |= depth[n] > level;
      if (more && (depth[n] == level || (node.count > 0 && depth[n] < level))) more = visit(node.box);
    }
    return deeper;
  }

 private:
  static constexpr std::uint32_t kLeaf = 8, kBlock = 4;  // only the last leaf is not full: see split
  static constexpr int kDepth = 64;
  struct Node {
    Aabb box;
    std::uint32_t first = 0;  // leaf: in items_; else the first of two children
    std::uint32_t count = 0;  // leaf: items; else 0
    std::uint32_t last = 0;   // largest item below
  };
  static constexpr std::uint32_t kLeafBit = 0x80000000u, kFirstMask = 0x0fffffffu, kCountShift = 28;
  using Block = BoxBlock;
  using Around = BoxAround;
  struct Four : Block {      // up to four nodes below one, in order
    std::uint32_t node[4];   // in nodes_
    std::uint32_t child[4];  // in fours_; a leaf: kLeafBit, its items less one, and its first item
  };
  template <class Test, class F>
  void descend(Test&& test, F&& visit_leaf) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[kDepth];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      if (!test(n)) continue;
      if (n.count > 0) {
        visit_leaf(n);
        continue;
      }
      stack[top++] = n.first + 1;
      stack[top++] = n.first;
    }
  }
  template <class F>
  void query_leaf(std::uint32_t first, std::uint32_t count, const Around& box, F&& visit) const {
    for (std::uint32_t k = first; k < first + count; k += kBlock)
      for (unsigned hit = overlapping(blocks_[k / kBlock], box); hit != 0; hit &= hit - 1)
        visit(items_[k + static_cast<unsigned>(std::countr_zero(hit))]);
  }
  void split(std::uint32_t node);
  void join_levels();
  std::uint32_t add_four(std::uint32_t node, bool one_level);
  void find_last();
  void fit();
  Real cost() const;

  Array<Node> nodes_;
  Array<Four> fours_;    // the same tree, two levels at a time
  Array<Block> blocks_;  // boxes of the items, in that order
  Array<std::uint32_t> items_;
  Array<BoxMiddle> sort_;        // in the order of items_
  Array<std::uint32_t> leaves_;  // of the descent under way
  std::span<const Aabb> boxes_;
  Real built_cost_ = 0;
};

}  // namespace feder
