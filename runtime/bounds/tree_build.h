// Builds of hierarchies: which items lie below which node, from their boxes alone. One file per build, one
// feder_variant(bounds <build> TABLE builds) line. Contract, checked for every build by
// tests/bounds/test_hierarchy.cpp: every item lies in one leaf, no leaf has more than asked for, whatever the boxes
// (equal ones too), and the same boxes give the same tree on every machine.
#pragma once
#include <span>
#include <string_view>
#include <vector>

#include "feder/types.h"

namespace feder {

struct TreeNode {
  std::uint32_t child = kNone;         // the first of two neighbours, which follow their parent; kNone: a leaf
  std::uint32_t first = 0, count = 0;  // items below it, in TreeShape::order
  bool leaf() const { return child == kNone; }
};
struct TreeShape {
  std::vector<TreeNode> nodes;  // the root first; none without items
  std::vector<std::uint32_t> order;
};

struct TreeBuild {
  const char* name;
  const char* summary;
  TreeShape (*build)(std::span<const Aabb> boxes, std::uint32_t leaf);
};
std::span<const TreeBuild> tree_builds();
const TreeBuild& tree_build(std::string_view name);  // SceneError

// For builds that halve: split(first, last) reorders items of order[first, last) and says where the second half begins;
// a share that leaves one of them empty is taken for the middle.
template <class Split>
TreeShape build_by_splits(std::uint32_t items, std::uint32_t leaf, Split&& split) {
  TreeShape tree;
  tree.order.resize(items);
  for (std::uint32_t i = 0; i < items; ++i) tree.order[i] = i;
  if (items == 0) return tree;
  tree.nodes.push_back({kNone, 0, items});
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const TreeNode node = tree.nodes[n];
    if (node.count <= leaf) continue;
    const std::uint32_t last = node.first + node.count;
    std::uint32_t middle = split(tree.order, node.first, last);
    if (middle <= node.first || middle >= last) middle = node.first + node.count / 2;
    tree.nodes[n].child = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes.push_back({kNone, node.first, middle - node.first});
    tree.nodes.push_back({kNone, middle, last - middle});
  }
  return tree;
}

// For builds that join: a node is an item, or two nodes.
struct TreeLink {
  std::uint32_t child[2] = {kNone, kNone};
  std::uint32_t item = kNone;
};
TreeShape shape_of_links(std::span<const TreeLink> links, std::uint32_t root, std::uint32_t leaf);

// Half the surface of a box, m^2.
inline double half_surface(const Aabb& b) {
  const double x = static_cast<double>(b.hi[0] - b.lo[0]), y = static_cast<double>(b.hi[1] - b.lo[1]),
               z = static_cast<double>(b.hi[2] - b.lo[2]);
  return b.empty() ? 0 : x * y + y * z + z * x;
}
inline Vec3 middle_of(const Aabb& b) { return b.lo + Real(0.5) * (b.hi - b.lo); }

}  // namespace feder
