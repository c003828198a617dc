// A tree of spheres over boxes that move little from call to call: a leaf's sphere encloses its boxes and some slack,
// an inner one the two below. A call looks at all boxes, but only leaves whose boxes have left their sphere get a new
// one, and only the nodes from there to the root are fitted again; so the nodes that are written follow what deforms.
// Sources: Hubbard, "Approximating polyhedra with spheres for time-critical collision detection" (1996); Quinlan,
// "Efficient distance computation between non-convex objects" (1994): two trees of spheres against each other; Brown et
// al., "Real-time simulation of deformable objects" (2001): the tree is updated below what moved only.
// Kept between calls: the tree. It is built anew, by halving along the longest side, for another number of boxes, when
// one becomes unbounded or bounded, and when its spheres have grown loose. Weak spot: spheres fit long boxes badly.
#pragma once
#include <span>

#include "bounds/box_block.h"
#include "bounds/box_search.h"
#include "bounds/middles.h"

namespace feder {

// Contract, checked against all pairs by tests/bounds/test_sphere_tree.cpp: exactly the overlapping pairs (closed
// boxes), ascending, whatever was asked before. Allocates only when boxes or pairs outnumber every earlier call.
class SphereTree {
 public:
  explicit SphereTree(Arena& a)
      : nodes_(&a), parent_(&a), stale_(&a), leaf_(&a), items_(&a), kept_(&a), blocks_(&a), side_(&a), sort_(&a),
        found_(&a), start_(&a), unsorted_(&a) {}

  // The boxes that the tree is of from now on.
  void update(std::span<const Aabb> boxes);
  // After update(b), or update(boxes), with the same boxes; replaces the content of `out`.
  void between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out);
  void within(std::span<const Aabb> boxes, Array<BoxPair>& out);

  std::size_t node_count() const { return nodes_.size(); }
  std::uint64_t node_updates() const { return updates_; }  // spheres made or fitted, since birth
  std::uint64_t builds() const { return builds_; }         // since birth

 private:
  static constexpr std::uint32_t kLeaf = 4;  // as a block has; only the last leaf is not full
  struct Sphere {
    Real center[3] = {};
    Real radius = 0;  // m
  };
  struct Node : Sphere {
    std::uint32_t first = 0;  // leaf: in items_; else the first of two children
    std::uint32_t count = 0;  // leaf: items; else 0
    std::uint32_t end = 0;    // in items_, of all below
  };

  void build(std::span<const Aabb> boxes);
  void split(std::uint32_t node);
  bool changed_side(std::span<const Aabb> boxes) const;
  bool renew_leaf(Node& leaf, std::span<const Aabb> boxes);
  void fit_leaf(Node& leaf);
  void fit_inner(Node& node);
  void refit();
  void keep(std::uint32_t slot, const Aabb& box) {
    kept_[slot] = box, blocks_[slot / kLeaf].put(static_cast<int>(slot % kLeaf), box);
  }
  Real farthest_corner(const Node& leaf, const Vec3& from) const;
  double cost() const;
  void find_leaves(const Sphere& sphere, std::uint32_t from);
  void sort_pairs(std::uint32_t count, Array<BoxPair>& out);
  static Sphere around(const Aabb& box);
  static bool meet(const Sphere& a, const Sphere& b);

  Array<Node> nodes_;  // children lie side by side after their parent
  Array<std::uint32_t> parent_;
  Array<std::uint8_t> stale_;   // by node: to be fitted
  Array<std::uint32_t> leaf_;   // nodes: leaves, in order
  Array<std::uint32_t> items_;  // in the order of the leaves
  Array<Aabb> kept_;            // their boxes
  Array<BoxBlock> blocks_;      // the same, four to a leaf
  Array<std::uint32_t> side_;   // boxes that no sphere encloses, ascending: compared with all
  Array<BoxMiddle> sort_;
  Array<std::uint32_t> found_;  // leaves of the descent under way
  Array<std::uint32_t> start_;  // work memory of sort_pairs
  Array<BoxPair> unsorted_;
  double built_cost_ = 0;
  std::uint64_t updates_ = 0, builds_ = 0;
};

}  // namespace feder
