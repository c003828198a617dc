// A binary tree of boxes that can be changed leaf by leaf. Used by the tree broad phase, one for still and one for
// moving boxes. Only finite boxes with lo <= hi.
// Source: insertion by surface area as in Omohundro, "Five Balltree Construction Algorithms" (1989), and Goldsmith
// and Salmon (1987), greedy single descent; rotations after Kopta et al., "Fast, Effective BVH Updates for Animated
// Scenes", I3D 2012. build() splits at the median of the centres along the longest axis.
// Kept between calls: everything. Weak spot: a greedy insertion order can give a poor tree; build() repairs it.
#pragma once
#include <span>

#include "bounds/box_query.h"
#include "bounds/middles.h"
#include "bounds/segment_box.h"
#include "bounds/work.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

class AabbTree {
 public:
  explicit AabbTree(Arena& arena) : nodes_(&arena), middles_(&arena), inner_(&arena) {}

  std::uint32_t leaves() const { return leaves_; }
  // The node of a new leaf that holds `item`.
  std::uint32_t insert(const Aabb& box, std::uint32_t item);
  void remove(std::uint32_t leaf);
  const Aabb& box(std::uint32_t node) const { return nodes_[node].box; }

  // Drops all leaves and makes one per item. `leaf_of[item]` receives the node.
  void build(std::span<const std::uint32_t> items, const Array<Aabb>& boxes, Array<std::uint32_t>& leaf_of);

  // The same leaves with other boxes, by item. Neighbours in the tree stay neighbours: build() now and then.
  void refit(const Array<Aabb>& boxes);

  // Calls visit(item) for every leaf whose box overlaps `box`, in no particular order.
  template <class Visit>
  void query(const Aabb& box, Visit&& visit) const {
    Uncounted none;
    query(box, visit, none);
  }
  template <class Visit, class Work>
  void query(const Aabb& box, Visit&& visit, Work& work) const {
    const BoxQuery query(box);
    descend(
        [&](const Aabb& node) {
          work.visit();
          return query.meets(node);
        },
        visit);
  }
  // Calls visit(item) for every leaf, neighbours in the tree one after another.
  template <class Visit>
  void each_leaf(Visit&& visit) const {
    descend([](const Aabb&) { return true; }, visit);
  }
  // A query among the leaves that each_leaf() visits after this one.
  template <class Visit, class Work>
  void query_after(std::uint32_t leaf, const Aabb& box, Visit&& visit, Work& work) const {
    const BoxQuery query(box);
    const auto test = [&](const Aabb& node) {
      work.visit();
      return query.meets(node);
    };
    for (std::uint32_t at = leaf, above = nodes_[at].parent; above != kNone; at = above, above = nodes_[at].parent)
      if (nodes_[above].child[0] == at) descend_from(nodes_[above].child[1], test, visit);
  }
  // Calls visit(box) for the nodes so many steps below the root and the leaves above them. Are there others below?
  template <class Visit>
  bool nodes_at(int level, Visit&& visit) const {
    return root_ != kNone && nodes_below(root_, level, visit);
  }
  template <class Visit>
  void query_ray(const Vec3& origin, const Vec3& ray, Visit&& visit) const {
    descend([&](const Aabb& node) { return segment_hits(node, origin, ray); }, visit);
  }

 private:
  struct Node {
    Aabb box;
    std::uint32_t parent = kNone;             // next free node when free
    std::uint32_t child[2] = {kNone, kNone};  // a leaf has child[0] == kNone and its item in child[1]
    bool leaf() const { return child[0] == kNone; }
  };

  // Depth-first with a stack of fixed size; a tree too deep for it is finished by recursion.
  template <class Test, class Visit>
  void descend(Test&& test, Visit&& visit) const {
    if (root_ != kNone) descend_from(root_, test, visit);
  }
  template <class Test, class Visit>
  void descend_from(std::uint32_t start, Test& test, Visit& visit) const {
    constexpr int kStack = 128;
    std::uint32_t stack[kStack];
    int top = 0;
    stack[top++] = start;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!test(node.box)) continue;
      if (node.leaf()) {
        visit(node.child[1]);
      } else if (top + 2 <= kStack) {
        stack[top++] = node.child[1];
        stack[top++] = node.child[0];
      } else {
        descend_from(node.child[0], test, visit);
        descend_from(node.child[1], test, visit);
      }
    }
  }

  template <class Visit>
  bool nodes_below(std::uint32_t at, int level, Visit& visit) const {
    const Node& n = nodes_[at];
    if (level == 0 || n.leaf()) return visit(n.box), !n.leaf();
    const bool first = nodes_below(n.child[0], level - 1, visit);
    return nodes_below(n.child[1], level - 1, visit) || first;
  }

  std::uint32_t take();
  void give_back(std::uint32_t node);
  std::uint32_t best_sibling(const Aabb& box) const;
  void refit_up(std::uint32_t node);
  void rotate(std::uint32_t node);
  std::uint32_t build_node(std::span<BoxMiddle> items, const Array<Aabb>& boxes, Array<std::uint32_t>& leaf_of);

  Array<Node> nodes_;
  Array<BoxMiddle> middles_;    // work memory of build()
  Array<std::uint32_t> inner_;  // nodes with children, each after its parent, while boxes are refitted
  std::uint32_t root_ = kNone;
  std::uint32_t free_ = kNone;
  std::uint32_t leaves_ = 0;
};

}  // namespace feder
