// Hierarchy and BoundingVolume for a kind of volume V, a plain value:
//   static V around(span<const Vec3> points, bool triangles)   holds all; at least one point
//   static V joined(const V&, const V&)                        holds what both hold
//   bool contains(p), overlaps(V), meets(Aabb), meets_ray(origin, ray)
//   double cost()    what a random query costs there: of the order of half its surface, m^2
//   double volume()
//   bool edges(EdgeVisitor)                                    for drawing
// Leaves keep the volumes of their items as well, so an item is found by its own.
#pragma once
#include <vector>

#include "base/borrowed_list.h"
#include "bounds/volume.h"

namespace feder {

template <class V>
class VolumeOf final : public BoundingVolume {
 public:
  explicit VolumeOf(V v) : v_(std::move(v)) {}
  bool contains(const Vec3& p) const override { return v_.contains(p); }
  bool overlaps(const BoundingVolume& o) const override { return v_.overlaps(static_cast<const VolumeOf&>(o).v_); }
  bool meets(const Aabb& box) const override { return v_.meets(box); }
  std::unique_ptr<BoundingVolume> merged(const BoundingVolume& o) const override {
    return std::make_unique<VolumeOf>(V::joined(v_, static_cast<const VolumeOf&>(o).v_));
  }
  double volume() const override { return v_.volume(); }
  bool edges(EdgeVisitor visit) const override { return v_.edges(visit); }

 private:
  V v_;
};

template <class V>
class HierarchyOf final : public Hierarchy {
 public:
  void build(ItemPoints items, const TreeBuild& how, std::uint32_t leaf) override {
    check_finite(items);
    how_ = &how, leaf_ = leaf, rebuilt_ = 0;
    find_boxes(items);
    tree_ = how.build(boxes_, leaf);
    items_.clear();
    for (const std::uint32_t i : tree_.order) items_.push_back(V::around(items.of(i), items.each == 3));
    volumes_.clear(), volumes_.reserve(tree_.nodes.size()), built_.clear();
    for (const TreeNode& n : tree_.nodes) volumes_.push_back(fitted(n, items));
    for (const V& v : volumes_) built_.push_back(v.cost());
  }

  void refit(ItemPoints items) override {
    if (items.count() != size() || !how_) return build(items, how_ ? *how_ : tree_builds()[0], how_ ? leaf_ : 1);
    if (items.count() == 0) return;
    check_finite(items);
    for (std::size_t k = 0; k < items_.size(); ++k) items_[k] = V::around(items.of(tree_.order[k]), items.each == 3);
    for (std::size_t n = volumes_.size(); n-- > 0;) join(n);
    rebuild_loose(items);
  }

  void query(const Aabb& box, ItemVisitor visit, HierarchyCost* cost) const override {
    find([&](const V& v) { return v.meets(box); }, visit, cost);
  }
  void query_ray(const Vec3& origin, const Vec3& ray, ItemVisitor visit, HierarchyCost* cost) const override {
    find([&](const V& v) { return v.meets_ray(origin, ray); }, visit, cost);
  }

  void pairs(PairVisitor visit, HierarchyCost* cost) const override {
    if (tree_.nodes.empty()) return;
    HierarchyCost tests;
    BorrowedList<std::pair<std::uint32_t, std::uint32_t>> borrowed;
    auto& stack = *borrowed;
    stack.push_back({0, 0});
    while (!stack.empty()) {
      const auto [a, b] = stack.back();
      stack.pop_back();
      const TreeNode &x = tree_.nodes[a], &y = tree_.nodes[b];
      if (a != b && (++tests.nodes, !volumes_[a].overlaps(volumes_[b]))) continue;
      if (x.leaf() && y.leaf()) {
        for (std::uint32_t i = x.first; i < x.first + x.count; ++i)
          for (std::uint32_t k = a == b ? i + 1 : y.first; k < y.first + y.count; ++k)
            if (++tests.items, items_[i].overlaps(items_[k])) visit(tree_.order[i], tree_.order[k]);
      } else if (a == b) {
        stack.push_back({x.child, x.child}), stack.push_back({x.child + 1, x.child + 1});
        stack.push_back({x.child, x.child + 1});
      } else if (y.leaf() || (!x.leaf() && x.count >= y.count)) {
        stack.push_back({x.child, b}), stack.push_back({x.child + 1, b});
      } else {
        stack.push_back({a, y.child}), stack.push_back({a, y.child + 1});
      }
    }
    add(cost, tests);
  }

  bool volumes_at(int level, EdgeVisitor visit) const override {
    std::vector<int> depth(tree_.nodes.size(), 0);
    bool more = true, deeper = false;
    for (std::size_t n = 0; n < depth.size(); ++n) {
      const TreeNode& node = tree_.nodes[n];
      if (!node.leaf()) depth[node.child] = depth[node.child + 1] = depth[n] + 1;  // they follow their parent
      deeper |= depth[n] > level;
      if (more && (depth[n] == level || (node.leaf() && depth[n] < level))) more = volumes_[n].edges(visit);
    }
    return deeper;
  }

  std::uint32_t size() const override { return static_cast<std::uint32_t>(tree_.order.size()); }
  std::size_t bytes() const override {
    return tree_.nodes.size() * (sizeof(TreeNode) + sizeof(V) + sizeof(double)) +
           tree_.order.size() * (sizeof(std::uint32_t) + sizeof(V) + sizeof(Aabb));
  }
  std::uint32_t rebuilt() const override { return rebuilt_; }

 private:
  static constexpr double kLoose = 1.5;  // cost of a subtree over that when it was built

  void find_boxes(ItemPoints items) {
    boxes_.assign(items.count(), Aabb{});
    for (std::uint32_t i = 0; i < items.count(); ++i)
      for (const Vec3& p : items.of(i)) boxes_[i].include(p);
  }
  // From the points of all items below, which is tighter than from the volumes of its children.
  V fitted(const TreeNode& n, ItemPoints items) {
    points_.clear();
    for (std::uint32_t k = n.first; k < n.first + n.count; ++k) {
      const std::span<const Vec3> of = items.of(tree_.order[k]);
      points_.insert(points_.end(), of.begin(), of.end());
    }
    return V::around(points_, items.each == 3);
  }
  void join(std::size_t n) {
    const TreeNode& node = tree_.nodes[n];
    if (!node.leaf()) {
      volumes_[n] = V::joined(volumes_[node.child], volumes_[node.child + 1]);
      return;
    }
    volumes_[n] = items_[node.first];
    for (std::uint32_t k = 1; k < node.count; ++k) volumes_[n] = V::joined(volumes_[n], items_[node.first + k]);
  }

  template <class Test>
  void find(Test&& test, ItemVisitor visit, HierarchyCost* cost) const {
    if (tree_.nodes.empty()) return;
    HierarchyCost tests;
    BorrowedList<std::uint32_t> borrowed;  // trees of insertion may be deep
    auto& stack = *borrowed;
    stack.push_back(0);
    while (!stack.empty()) {
      const TreeNode& n = tree_.nodes[stack.back()];
      const V& v = volumes_[stack.back()];
      stack.pop_back();
      ++tests.nodes;
      if (!test(v)) continue;
      if (!n.leaf()) {
        stack.push_back(n.child + 1), stack.push_back(n.child);
        continue;
      }
      for (std::uint32_t k = n.first; k < n.first + n.count; ++k)
        if (n.count == 1 || (++tests.items, test(items_[k]))) visit(tree_.order[k]);
    }
    add(cost, tests);
  }
  static void add(HierarchyCost* cost, const HierarchyCost& tests) {
    if (cost) cost->nodes += tests.nodes, cost->items += tests.items;
  }

  // The topmost subtrees that have grown loose are built anew from the boxes of their items, and put where they were.
  void rebuild_loose(ItemPoints items) {
    std::vector<std::uint32_t> loose, stack{0};
    while (!stack.empty()) {
      const std::uint32_t n = stack.back();
      stack.pop_back();
      const TreeNode& node = tree_.nodes[n];
      if (node.leaf()) continue;
      if (volumes_[n].cost() > kLoose * built_[n])
        loose.push_back(n);
      else
        stack.push_back(node.child + 1), stack.push_back(node.child);
    }
    if (loose.empty()) return;
    rebuilt_ += static_cast<std::uint32_t>(loose.size());
    find_boxes(items);
    for (const std::uint32_t n : loose) replace(n, items);
    sort_levels();
  }
  // Its nodes are added at the end; the old ones are left behind for sort_levels.
  void replace(std::uint32_t n, ItemPoints items) {
    const TreeNode old = tree_.nodes[n];
    std::vector<Aabb> boxes;
    for (std::uint32_t k = old.first; k < old.first + old.count; ++k) boxes.push_back(boxes_[tree_.order[k]]);
    const TreeShape sub = how_->build(boxes, leaf_);
    const std::vector<std::uint32_t> before(tree_.order.begin() + old.first,
                                            tree_.order.begin() + old.first + old.count);
    const std::vector<V> volumes(items_.begin() + old.first, items_.begin() + old.first + old.count);
    for (std::uint32_t k = 0; k < old.count; ++k)
      tree_.order[old.first + k] = before[sub.order[k]], items_[old.first + k] = volumes[sub.order[k]];
    const auto base = static_cast<std::uint32_t>(tree_.nodes.size()) - 1;  // node 0 of the subtree takes the old place
    for (std::size_t k = 0; k < sub.nodes.size(); ++k) {
      TreeNode node = sub.nodes[k];
      node.first += old.first;
      if (!node.leaf()) node.child += base;
      if (k == 0) {
        tree_.nodes[n] = node, volumes_[n] = fitted(node, items), built_[n] = volumes_[n].cost();
      } else {
        tree_.nodes.push_back(node), volumes_.push_back(fitted(node, items));
        built_.push_back(volumes_.back().cost());
      }
    }
  }
  void sort_levels() {
    TreeShape sorted;
    std::vector<V> volumes;
    std::vector<double> built;
    std::vector<std::uint32_t> from{0};
    for (std::size_t k = 0; k < from.size(); ++k) {
      TreeNode node = tree_.nodes[from[k]];
      volumes.push_back(volumes_[from[k]]), built.push_back(built_[from[k]]);
      if (!node.leaf()) {
        const std::uint32_t child = node.child;
        node.child = static_cast<std::uint32_t>(from.size());
        from.push_back(child), from.push_back(child + 1);
      }
      sorted.nodes.push_back(node);
    }
    tree_.nodes.swap(sorted.nodes), volumes_.swap(volumes), built_.swap(built);
  }

  const TreeBuild* how_ = nullptr;
  std::uint32_t leaf_ = 1, rebuilt_ = 0;
  TreeShape tree_;
  std::vector<V> volumes_, items_;  // by node; in the order of the tree
  std::vector<double> built_;       // by node: its cost when it was built
  std::vector<Aabb> boxes_;
  std::vector<Vec3> points_;
};

template <class V>
VolumeKind volume_kind(const char* name, const char* summary) {
  return {name, summary,
          [](ItemPoints items) -> std::unique_ptr<BoundingVolume> {
            check_finite(items);
            if (items.points.empty()) fail_empty_volume();
            return std::make_unique<VolumeOf<V>>(V::around(items.points, items.each == 3));
          },
          []() -> std::unique_ptr<Hierarchy> { return std::make_unique<HierarchyOf<V>>(); }};
}

}  // namespace feder
