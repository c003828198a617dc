// Insertion by surface, rotations on the way up, and building by medians; sources and weak spot: aabb_tree.h.
#include "bounds/aabb_tree.h"

#include <algorithm>

namespace feder {
namespace {

Aabb joined(const Aabb& a, const Aabb& b) { return {a.lo.cwiseMin(b.lo), a.hi.cwiseMax(b.hi)}; }

// Half the surface, m^2: proportional to the chance that a random ray or box meets it.
Real area(const Aabb& b) {
  const Vec3 d = b.hi - b.lo;
  return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

}  // namespace

std::uint32_t AabbTree::take() {
  if (free_ == kNone) {
    nodes_.push_back({});
    return static_cast<std::uint32_t>(nodes_.size() - 1);
  }
  const std::uint32_t n = free_;
  free_ = nodes_[n].parent;
  nodes_[n] = {};
  return n;
}

void AabbTree::give_back(std::uint32_t node) {
  nodes_[node].parent = free_;
  free_ = node;
}

// Where a new leaf costs least surface: at each node either stop and become its sibling, or go on into the child
// whose surface grows less.
std::uint32_t AabbTree::best_sibling(const Aabb& box) const {
  std::uint32_t at = root_;
  while (!nodes_[at].leaf()) {
    const Node& node = nodes_[at];
    const Real whole = area(node.box), with = area(joined(node.box, box));
    const Real here = 2 * with;
    const Real inherited = 2 * (with - whole);
    Real cost[2];
    for (int k = 0; k < 2; ++k) {
      const Node& child = nodes_[node.child[k]];
      const Real grown = area(joined(child.box, box));
      cost[k] = inherited + (child.leaf() ? grown : grown - area(child.box));
    }
    if (here < cost[0] && here < cost[1]) break;
    at = cost[0] <= cost[1] ? node.child[0] : node.child[1];
  }
  return at;
}

std::uint32_t AabbTree::insert(const Aabb& box, std::uint32_t item) {
  const std::uint32_t leaf = take();
  nodes_[leaf].box = box;
  nodes_[leaf].child[1] = item;
  ++leaves_;
  if (root_ == kNone) return root_ = leaf;
  const std::uint32_t sibling = best_sibling(box);
  const std::uint32_t parent = take();
  const std::uint32_t above = nodes_[sibling].parent;
  nodes_[parent].parent = above;
  nodes_[parent].child[0] = sibling;
  nodes_[parent].child[1] = leaf;
  nodes_[sibling].parent = nodes_[leaf].parent = parent;
  if (above == kNone) {
    root_ = parent;
  } else {
    nodes_[above].child[nodes_[above].child[0] == sibling ? 0 : 1] = parent;
  }
  refit_up(parent);
  return leaf;
}

void AabbTree::remove(std::uint32_t leaf) {
  --leaves_;
  const std::uint32_t parent = nodes_[leaf].parent;
  give_back(leaf);
  if (parent == kNone) {
    root_ = kNone;
    return;
  }
  const std::uint32_t sibling = nodes_[parent].child[nodes_[parent].child[0] == leaf ? 1 : 0];
  const std::uint32_t above = nodes_[parent].parent;
  nodes_[sibling].parent = above;
  give_back(parent);
  if (above == kNone) {
    root_ = sibling;
    return;
  }
  nodes_[above].child[nodes_[above].child[0] == parent ? 0 : 1] = sibling;
  refit_up(above);
}

void AabbTree::refit_up(std::uint32_t node) {
  for (; node != kNone; node = nodes_[node].parent) {
    Node& n = nodes_[node];
    n.box = joined(nodes_[n.child[0]].box, nodes_[n.child[1]].box);
    rotate(node);
  }
}

// Swaps a child of `top` with a grandchild on the other side when that shrinks the other side.
void AabbTree::rotate(std::uint32_t top) {
  int best_side = -1, best_grand = 0;
  Real best_gain = 0;
  for (int side = 0; side < 2; ++side) {
    const std::uint32_t lower = nodes_[top].child[side], other = nodes_[top].child[1 - side];
    if (nodes_[lower].leaf()) continue;
    for (int grand = 0; grand < 2; ++grand) {
      const std::uint32_t stays = nodes_[lower].child[1 - grand];
      const Real gain = area(nodes_[lower].box) - area(joined(nodes_[stays].box, nodes_[other].box));
      if (gain > best_gain) best_gain = gain, best_side = side, best_grand = grand;
    }
  }
  if (best_side < 0) return;
  const std::uint32_t lower = nodes_[top].child[best_side], other = nodes_[top].child[1 - best_side];
  const std::uint32_t rises = nodes_[lower].child[best_grand];
  nodes_[top].child[1 - best_side] = rises;
  nodes_[rises].parent = top;
  nodes_[lower].child[best_grand] = other;
  nodes_[other].parent = lower;
  nodes_[lower].box = joined(nodes_[nodes_[lower].child[0]].box, nodes_[nodes_[lower].child[1]].box);
}

void AabbTree::build(std::span<const std::uint32_t> items, const Array<Aabb>& boxes, Array<std::uint32_t>& leaf_of) {
  nodes_.clear(), middles_.clear();
  free_ = root_ = kNone;
  leaves_ = static_cast<std::uint32_t>(items.size());
  for (const std::uint32_t i : items) {
    const Vec3 c = Real(0.5) * (boxes[i].lo + boxes[i].hi);
    middles_.push_back({{c[0], c[1], c[2]}, i});
  }
  if (!items.empty()) root_ = build_node({middles_.data(), middles_.size()}, boxes, leaf_of);
}

void AabbTree::refit(const Array<Aabb>& boxes) {
  inner_.clear();
  inner_.reserve(nodes_.size());
  if (leaves_ > 1) inner_.push_back(root_);
  for (std::size_t k = 0; k < inner_.size(); ++k)
    for (const std::uint32_t child : nodes_[inner_[k]].child)
      if (!nodes_[child].leaf()) inner_.push_back(child);
  if (leaves_ == 1) nodes_[root_].box = boxes[nodes_[root_].child[1]];
  for (std::size_t k = inner_.size(); k-- > 0;) {
    Node& node = nodes_[inner_[k]];
    for (const std::uint32_t child : node.child)
      if (nodes_[child].leaf()) nodes_[child].box = boxes[nodes_[child].child[1]];
    node.box = joined(nodes_[node.child[0]].box, nodes_[node.child[1]].box);
  }
}

std::uint32_t AabbTree::build_node(std::span<BoxMiddle> items, const Array<Aabb>& boxes,
                                   Array<std::uint32_t>& leaf_of) {
  const std::uint32_t node = take();
  if (items.size() == 1) {
    nodes_[node].box = boxes[items[0].item];
    nodes_[node].child[1] = items[0].item;
    return leaf_of[items[0].item] = node;
  }
  const std::size_t half = items.size() / 2;
  divide_middles(items, half);
  const std::uint32_t left = build_node(items.first(half), boxes, leaf_of);
  const std::uint32_t right = build_node(items.subspan(half), boxes, leaf_of);
  nodes_[node].child[0] = left, nodes_[node].child[1] = right;
  nodes_[left].parent = nodes_[right].parent = node;
  nodes_[node].box = joined(nodes_[left].box, nodes_[right].box);
  return node;
}

}  // namespace feder
