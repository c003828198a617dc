// The tree of a build that joins: nodes level by level, children side by side after their parents, small subtrees as
// one leaf.
#include "bounds/tree_build.h"

namespace feder {

TreeShape shape_of_links(std::span<const TreeLink> links, std::uint32_t root, std::uint32_t leaf) {
  TreeShape tree;
  if (root == kNone) return tree;
  // children before parents, whatever the order of the links: by a walk without recursion, as chains may be long
  std::vector<std::uint32_t> walk{root}, below(links.size(), 1);
  for (std::size_t k = 0; k < walk.size(); ++k)
    for (const std::uint32_t child : links[walk[k]].child)
      if (child != kNone) walk.push_back(child);
  for (std::size_t k = walk.size(); k-- > 0;) {
    const TreeLink& link = links[walk[k]];
    if (link.item == kNone) below[walk[k]] = below[link.child[0]] + below[link.child[1]];
  }
  std::vector<std::uint32_t> of{root};  // link of a node
  tree.nodes.push_back({kNone, 0, below[root]});
  tree.order.resize(below[root]);
  std::vector<std::uint32_t> stack;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const TreeNode node = tree.nodes[n];
    const TreeLink& link = links[of[n]];
    if (node.count <= leaf || link.item != kNone) {
      std::uint32_t at = node.first;
      stack.assign(1, of[n]);
      while (!stack.empty()) {
        const TreeLink& l = links[stack.back()];
        stack.pop_back();
        if (l.item != kNone)
          tree.order[at++] = l.item;
        else
          stack.push_back(l.child[1]), stack.push_back(l.child[0]);
      }
      continue;
    }
    tree.nodes[n].child = static_cast<std::uint32_t>(tree.nodes.size());
    std::uint32_t first = node.first;
    for (const std::uint32_t child : link.child) {
      tree.nodes.push_back({kNone, first, below[child]});
      of.push_back(child);
      first += below[child];
    }
  }
  return tree;
}

}  // namespace feder
