// Insertion, one item after another: each becomes the sibling of the node where the surfaces of all boxes above grow
// least, found by branch and bound. Weak spot: the tree depends on the order of the items; equal ones make a chain.
// Sources: Goldsmith & Salmon 1987; Omohundro, "Five Balltree Construction Algorithms", ICSI 1989; Bittner, Hapala &
// Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", CGF 2013.
#include <algorithm>
#include <queue>

#include "bounds/tree_build.h"

namespace feder {
namespace {

struct InsertedNode {
  Aabb box;
  std::uint32_t parent = kNone;
};

class Insertion {
 public:
  void insert(const Aabb& box, std::uint32_t item) {
    const std::uint32_t leaf = add(box);
    links_[leaf].item = item;
    if (leaf == 0) {
      root_ = 0;
      return;
    }
    const std::uint32_t sibling = best_sibling(box), above = nodes_[sibling].parent;
    const std::uint32_t joint = add(nodes_[sibling].box);
    links_[joint].child[0] = sibling, links_[joint].child[1] = leaf;
    nodes_[joint].parent = above, nodes_[sibling].parent = nodes_[leaf].parent = joint;
    if (above == kNone)
      root_ = joint;
    else
      links_[above].child[links_[above].child[1] == sibling] = joint;
    for (std::uint32_t n = joint; n != kNone; n = nodes_[n].parent) nodes_[n].box.include(box);
  }
  TreeShape shape(std::uint32_t leaf) const { return shape_of_links(links_, root_, leaf); }

 private:
  struct Candidate {
    double grown;  // of the boxes above it
    std::uint32_t node;
    bool operator<(const Candidate& o) const { return grown != o.grown ? grown > o.grown : node > o.node; }
  };

  std::uint32_t add(const Aabb& box) {
    nodes_.push_back({box, kNone}), links_.push_back({});
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  std::uint32_t best_sibling(const Aabb& box) {
    const double own = half_surface(box);
    double least = 1e300;
    std::uint32_t best = root_;
    std::priority_queue<Candidate> queue;
    queue.push({0, root_});
    while (!queue.empty()) {
      const Candidate at = queue.top();
      queue.pop();
      if (at.grown + own >= least) break;
      Aabb both = nodes_[at.node].box;
      both.include(box);
      const double joint = half_surface(both), cost = at.grown + joint;
      if (cost < least) least = cost, best = at.node;
      const double below = cost - half_surface(nodes_[at.node].box);
      if (links_[at.node].item == kNone && below + own < least)
        for (const std::uint32_t child : links_[at.node].child) queue.push({below, child});
    }
    return best;
  }

  std::vector<InsertedNode> nodes_;
  std::vector<TreeLink> links_;  // of the same numbers
  std::uint32_t root_ = kNone;
};

}  // namespace

TreeBuild bounds_insertion() {
  return {"insertion", "inserts one after another where the surfaces grow least",
          [](std::span<const Aabb> boxes, std::uint32_t leaf) {
            Insertion tree;
            for (std::uint32_t i = 0; i < boxes.size(); ++i) tree.insert(boxes[i], i);
            return tree.shape(leaf);
          }};
}

}  // namespace feder
