// Median split: the items of a node are ordered by their middles along the longest side and halved, but for what makes
// the first half fill whole leaves, so the depth is logarithmic whatever the input (equal middles are told apart by
// index), every leaf begins with a block of four, and only the last is not full. Children lie side by side after their
// parent, so a backward sweep refits. Weak spot: no surface heuristic; triangles of a sheet need none.
// Source: Ericson, "Real-Time Collision Detection" (2005), 6.2.
#include "bounds/box_tree.h"

#include <algorithm>
#include <limits>

#include "feder/error.h"

namespace feder {

void BoxTree::build(std::span<const Aabb> boxes) {
  boxes_ = boxes;
  const auto count = static_cast<std::uint32_t>(boxes.size());
  items_.resize(count), sort_.resize(count);
  nodes_.clear(), fours_.clear();
  if (count == 0) return;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 middle = Real(0.5) * (boxes[i].lo + boxes[i].hi);
    sort_[i] = {{middle[0], middle[1], middle[2]}, i};
  }
  nodes_.reserve(2 * count);
  nodes_.push_back({{}, 0, count, 0});
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) split(n);
  for (std::uint32_t i = 0; i < count; ++i) items_[i] = sort_[i].item;
  // std::nth_element leaves the order within a leaf to the library
  for (const Node& n : nodes_)
    if (n.count > 0) std::sort(items_.begin() + n.first, items_.begin() + n.first + n.count);
  find_last();
  join_levels();
  fit();
  built_cost_ = cost();
}

void BoxTree::split(std::uint32_t node) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  if (count <= kLeaf) return;
  const std::uint32_t half = std::max((count / 2 + kLeaf / 2) / kLeaf, 1u) * kLeaf;
  divide_middles({sort_.data() + first, count}, half);
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, half, 0});
  nodes_.push_back({{}, first + half, count - half, 0});
  nodes_[node].first = child, nodes_[node].count = 0;
}

// Below the root an even number of levels, so that the last ones are full.
void BoxTree::join_levels() {
  int depth = 0;
  for (std::uint32_t n = 0; nodes_[n].count == 0; n = nodes_[n].first) ++depth;
  fours_.reserve(nodes_.size() / 2 + 1);
  add_four(0, depth % 2 != 0);
  // children follow their parents, so the list grows while it is walked
  for (std::uint32_t f = 0; f < fours_.size(); ++f)
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t node = fours_[f].node[k];
      if (node == kNone) continue;
      const Node& n = nodes_[node];
      const bool leaf = n.count > 0;
      FEDER_ASSERT(!leaf || (n.first <= kFirstMask && n.count <= kLeaf));
      const std::uint32_t child = leaf ? kLeafBit | (n.count - 1) << kCountShift | n.first : add_four(node, false);
      fours_[f].child[k] = child;
    }
}

std::uint32_t BoxTree::add_four(std::uint32_t node, bool one_level) {
  Four four{};
  int used = 0;
  const auto add = [&](std::uint32_t n) { four.node[used++] = n; };
  const auto halves = [&](std::uint32_t n) {
    if (nodes_[n].count > 0 || one_level) return add(n);
    add(nodes_[n].first), add(nodes_[n].first + 1);
  };
  if (nodes_[node].count > 0)
    add(node);
  else
    halves(nodes_[node].first), halves(nodes_[node].first + 1);
  while (used < 4) add(kNone);
  fours_.push_back(four);
  return static_cast<std::uint32_t>(fours_.size() - 1);
}

void BoxTree::find_last() {
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.count == 0) {
      node.last = std::max(nodes_[node.first].last, nodes_[node.first + 1].last);
      continue;
    }
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) node.last = std::max(node.last, items_[k]);
  }
}

void BoxTree::fit() {
  const Vec3 none = Vec3::Constant(std::numeric_limits<Real>::quiet_NaN());
  blocks_.resize((items_.size() + kBlock - 1) / kBlock);
  for (std::size_t k = 0; k < kBlock * blocks_.size(); ++k)
    blocks_[k / kBlock].put(static_cast<int>(k % kBlock), k < items_.size() ? boxes_[items_[k]] : Aabb{none, none});
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.box = Aabb{};
    if (node.count > 0)
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) node.box.include(boxes_[items_[k]]);
    else
      node.box.include(nodes_[node.first].box), node.box.include(nodes_[node.first + 1].box);
  }
  for (Four& f : fours_)
    for (int k = 0; k < 4; ++k) f.put(k, f.node[k] == kNone ? Aabb{none, none} : nodes_[f.node[k]].box);
}

void BoxTree::number_in_order() {
  boxes_ = {};
  for (std::uint32_t i = 0; i < items_.size(); ++i) items_[i] = i;
  sort_.clear(), sort_.shrink_to_fit();  // of use to the next build only
  find_last();
}

Real BoxTree::cost() const {
  Real sum = 0;
  for (const Node& n : nodes_) {
    const Vec3 d = n.box.hi - n.box.lo;
    sum += d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
  return sum;
}

void BoxTree::refit(std::span<const Aabb> boxes) {
  if (boxes.size() != items_.size() || boxes.empty()) return build(boxes);
  boxes_ = boxes;
  fit();
  if (!(cost() <= Real(1.5) * built_cost_)) build(boxes);
}

}  // namespace feder
