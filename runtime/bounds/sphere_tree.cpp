// Building, updating and asking a tree of spheres; sources and weak spot: sphere_tree.h. Radii are rounded outward, so
// spheres only sort out pairs whose boxes do not overlap, and the boxes themselves decide.
#include "bounds/sphere_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "feder/error.h"

namespace feder {
namespace {

constexpr Real kSphereSlack = Real(1.1);  // of a leaf's radius, so that what trembles stays inside
constexpr Real kSphereLoose = Real(0.6);  // a leaf that needs less of its radius is fitted
constexpr double kCostGrowth = 1.5;       // of the tree, from which it is built anew
constexpr Real kOutward = 1 + 16 * std::numeric_limits<Real>::epsilon();
constexpr Real kFarthest = Real(1e15);  // m; beyond it squares overflow in single precision

bool in_sphere_range(const Aabb& b) {
  for (int k = 0; k < 3; ++k)
    if (!(b.lo[k] >= -kFarthest && b.lo[k] <= kFarthest && b.hi[k] >= -kFarthest && b.hi[k] <= kFarthest)) return false;
  return true;
}

bool same_box(const Aabb& a, const Aabb& b) { return std::memcmp(&a, &b, sizeof(Aabb)) == 0; }

// From a point to the corner of a box that is farthest from it, squared.
Real corner_square(const Aabb& b, const Vec3& from) {
  const Vec3 far = (b.lo - from).cwiseAbs().cwiseMax((b.hi - from).cwiseAbs());
  return dot(far, far);
}

}  // namespace

SphereTree::Sphere SphereTree::around(const Aabb& box) {
  const Vec3 c = Real(0.5) * (box.lo + box.hi);
  return {{c[0], c[1], c[2]}, std::sqrt(corner_square(box, c)) * kOutward};
}

bool SphereTree::meet(const Sphere& a, const Sphere& b) {
  const Real x = a.center[0] - b.center[0], y = a.center[1] - b.center[1], z = a.center[2] - b.center[2];
  const Real r = a.radius + b.radius;
  return x * x + y * y + z * z <= r * r * kOutward;
}

Real SphereTree::farthest_corner(const Node& leaf, const Vec3& from) const {
  Real most = 0;
  for (std::uint32_t s = leaf.first; s < leaf.first + leaf.count; ++s)
    most = std::max(most, corner_square(kept_[s], from));
  return std::sqrt(most) * kOutward;
}

void SphereTree::fit_leaf(Node& leaf) {
  Aabb all = kept_[leaf.first];
  for (std::uint32_t s = leaf.first + 1; s < leaf.first + leaf.count; ++s) all.include(kept_[s]);
  const Vec3 c = Real(0.5) * (all.lo + all.hi);
  for (int k = 0; k < 3; ++k) leaf.center[k] = c[k];
  leaf.radius = kSphereSlack * farthest_corner(leaf, c);
  ++updates_;
}

// The smallest sphere round the two below.
void SphereTree::fit_inner(Node& node) {
  const Node &p = nodes_[node.first], &q = nodes_[node.first + 1];
  const Vec3 a(p.center[0], p.center[1], p.center[2]), b(q.center[0], q.center[1], q.center[2]);
  const Real apart = length(Vec3(b - a)), r = Real(0.5) * (apart + p.radius + q.radius);
  Vec3 c = p.radius > q.radius ? a : b;
  if (apart + std::min(p.radius, q.radius) > std::max(p.radius, q.radius)) c = a + (b - a) * ((r - p.radius) / apart);
  // from where rounding put the centre
  node.radius = std::max(length(Vec3(c - a)) + p.radius, length(Vec3(c - b)) + q.radius) * kOutward;
  for (int k = 0; k < 3; ++k) node.center[k] = c[k];
  ++updates_;
}

void SphereTree::build(std::span<const Aabb> boxes) {
  const auto count = static_cast<std::uint32_t>(boxes.size());
  nodes_.clear(), sort_.clear(), side_.clear(), leaf_.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!in_sphere_range(boxes[i])) {
      side_.push_back(i);
      continue;
    }
    const Vec3 middle = Real(0.5) * (boxes[i].lo + boxes[i].hi);
    sort_.push_back({{middle[0], middle[1], middle[2]}, i});
  }
  const auto inside = static_cast<std::uint32_t>(sort_.size());
  ++builds_;
  items_.resize(inside), kept_.resize(inside);
  built_cost_ = 0;
  if (inside == 0) return parent_.clear(), stale_.clear();
  nodes_.reserve(inside), parent_.clear();
  nodes_.push_back({{}, 0, inside, inside}), parent_.push_back(kNone);
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) split(n);
  for (std::uint32_t s = 0; s < inside; ++s) items_[s] = sort_[s].item;
  // std::nth_element leaves the order within a leaf to the library
  for (const Node& n : nodes_)
    if (n.count > 0) std::sort(items_.begin() + n.first, items_.begin() + n.first + n.count);
  leaf_.resize((inside + kLeaf - 1) / kLeaf), blocks_.resize(leaf_.size());
  for (std::uint32_t k = 0; k < nodes_.size(); ++k)
    if (nodes_[k].count > 0) leaf_[nodes_[k].first / kLeaf] = k;
  const Vec3 none = Vec3::Constant(std::numeric_limits<Real>::quiet_NaN());
  for (std::uint32_t s = 0; s < inside; ++s) keep(s, boxes[items_[s]]);
  for (std::uint32_t s = inside; s < kLeaf * blocks_.size(); ++s)
    blocks_[s / kLeaf].put(static_cast<int>(s % kLeaf), Aabb{none, none});
  stale_.assign(nodes_.size(), 1);
  refit();
  built_cost_ = cost();
}

void SphereTree::split(std::uint32_t node) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  if (count <= kLeaf) return;
  const std::uint32_t half = std::max((count / 2 + kLeaf / 2) / kLeaf, 1u) * kLeaf;
  divide_middles({sort_.data() + first, count}, half);
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, half, first + half}), parent_.push_back(node);
  nodes_.push_back({{}, first + half, count - half, first + count}), parent_.push_back(node);
  nodes_[node].first = child, nodes_[node].count = 0;
}

// Fits the stale nodes; children come after their parents.
void SphereTree::refit() {
  for (std::size_t k = nodes_.size(); k-- > 0;) {
    if (!stale_[k]) continue;
    stale_[k] = 0;
    nodes_[k].count > 0 ? fit_leaf(nodes_[k]) : fit_inner(nodes_[k]);
  }
}

bool SphereTree::changed_side(std::span<const Aabb> boxes) const {
  return std::any_of(side_.begin(), side_.end(), [&](std::uint32_t i) { return in_sphere_range(boxes[i]); });
}

// Takes over a leaf's boxes; false: one of them has no sphere any more.
bool SphereTree::renew_leaf(Node& leaf, std::span<const Aabb> boxes) {
  bool changed = false;
  for (std::uint32_t s = leaf.first; s < leaf.first + leaf.count; ++s) {
    const Aabb& box = boxes[items_[s]];
    if (same_box(kept_[s], box)) continue;
    if (!in_sphere_range(box)) return false;
    keep(s, box), changed = true;
  }
  if (!changed) return true;
  const Real wanted = farthest_corner(leaf, Vec3(leaf.center[0], leaf.center[1], leaf.center[2]));
  if (wanted <= leaf.radius && wanted >= kSphereLoose * leaf.radius) return true;
  for (auto n = static_cast<std::uint32_t>(&leaf - nodes_.data()); n != kNone && !stale_[n]; n = parent_[n])
    stale_[n] = 1;
  return true;
}

void SphereTree::update(std::span<const Aabb> boxes) {
  if (boxes.size() != items_.size() + side_.size() || changed_side(boxes)) return build(boxes);
  for (Node& n : nodes_)
    if (n.count > 0 && !renew_leaf(n, boxes)) return build(boxes);
  if (nodes_.empty() || !stale_[0]) return;
  refit();
  if (!(cost() <= kCostGrowth * built_cost_)) build(boxes);
}

// Proportional to the surfaces.
double SphereTree::cost() const {
  double sum = 0;
  for (const Node& n : nodes_) sum += static_cast<double>(n.radius) * static_cast<double>(n.radius);
  return sum;
}

// Leaves whose spheres meet this one, those that begin before `from` left out.
void SphereTree::find_leaves(const Sphere& sphere, std::uint32_t from) {
  found_.clear();
  if (nodes_.empty()) return;
  std::uint32_t stack[64];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const std::uint32_t at = stack[--top];
    const Node& n = nodes_[at];
    if (n.end <= from || !meet(n, sphere)) continue;
    if (n.count > 0)
      found_.push_back(at);
    else
      stack[top++] = n.first, stack[top++] = n.first + 1;
  }
}

void SphereTree::between(std::span<const Aabb> a, std::span<const Aabb> b, Array<BoxPair>& out) {
  FEDER_ASSERT(b.size() == items_.size() + side_.size());
  constexpr std::uint32_t kTogether = 8;  // neighbours in number are so in space: one descent for a few of them
  out.clear();
  const auto count = static_cast<std::uint32_t>(a.size());
  for (std::uint32_t first = 0; first < count; first += kTogether) {
    const std::uint32_t end = std::min(first + kTogether, count);
    Aabb all;
    found_.clear();
    for (std::uint32_t i = first; i < end; ++i)
      if (in_sphere_range(a[i])) all.include(a[i]);
    if (!all.empty()) find_leaves(around(all), 0);
    for (std::uint32_t i = first; i < end; ++i) {
      const auto begin = static_cast<std::ptrdiff_t>(out.size());
      if (!in_sphere_range(a[i])) {
        for (std::uint32_t j = 0; j < b.size(); ++j)
          if (overlaps(a[i], b[j])) out.push_back({i, j});
        continue;
      }
      const BoxAround own(a[i]);
      for (const std::uint32_t leaf : found_) {
        const std::uint32_t slot = nodes_[leaf].first;
        for (unsigned hit = overlapping(blocks_[slot / kLeaf], own); hit != 0; hit &= hit - 1)
          out.push_back({i, items_[slot + static_cast<std::uint32_t>(std::countr_zero(hit))]});
      }
      for (const std::uint32_t j : side_)
        if (overlaps(a[i], b[j])) out.push_back({i, j});
      std::sort(out.begin() + begin, out.end());
    }
  }
}

// Each leaf with itself and with later ones.
void SphereTree::within(std::span<const Aabb> boxes, Array<BoxPair>& out) {
  FEDER_ASSERT(boxes.size() == items_.size() + side_.size());
  unsorted_.clear();
  const auto add = [&](std::uint32_t i, std::uint32_t j) { unsorted_.push_back({std::min(i, j), std::max(i, j)}); };
  for (const std::uint32_t from : leaf_) {
    const Node& a = nodes_[from];
    find_leaves(a, a.first);
    for (std::uint32_t s = a.first; s < a.end; ++s) {
      const BoxAround own(kept_[s]);
      for (const std::uint32_t leaf : found_) {
        const std::uint32_t slot = nodes_[leaf].first;
        unsigned hit = overlapping(blocks_[slot / kLeaf], own);
        if (leaf == from) hit &= ~0u << (s - slot) << 1;  // later ones
        for (; hit != 0; hit &= hit - 1)
          add(items_[s], items_[slot + static_cast<std::uint32_t>(std::countr_zero(hit))]);
      }
    }
  }
  for (const std::uint32_t i : side_) {
    for (const std::uint32_t j : items_)
      if (overlaps(boxes[i], boxes[j])) add(i, j);
    for (const std::uint32_t j : side_)
      if (j > i && overlaps(boxes[i], boxes[j])) add(i, j);
  }
  sort_pairs(static_cast<std::uint32_t>(boxes.size()), out);
}

// A counting sort by the first, and each short run by the second.
void SphereTree::sort_pairs(std::uint32_t count, Array<BoxPair>& out) {
  start_.assign(count + 1, 0), out.resize(unsorted_.size());
  for (const BoxPair& p : unsorted_) ++start_[p.a + 1];
  for (std::uint32_t i = 0; i < count; ++i) start_[i + 1] += start_[i];
  for (const BoxPair& p : unsorted_) out[start_[p.a]++] = p;  // start_ then says where runs end
  for (std::uint32_t i = 0; i < count; ++i)
    std::sort(out.begin() + (i > 0 ? start_[i - 1] : 0), out.begin() + start_[i]);
}

}  // namespace feder
