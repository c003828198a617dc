// k-d tree: planes across the longest side at the median of the middles, as long as that parts the triangles; those
// that a plane cuts lie on both sides, and are found twice. Weak spot: long triangles lie in
// many leaves; a split that leaves more than half of them on both sides is not made, nor any once there are five times
// as many entries as triangles. Source: Ericson, "Real-Time Collision Detection" (2005), 7.3.
#include <algorithm>

#include "geom/mesh_index.h"

namespace feder {
namespace {

constexpr int kDeepest = 40;
constexpr std::size_t kMostTwice = 4;  // per triangle, in all

class KdTreeIndex final : public TriangleIndex {
 public:
  KdTreeIndex(std::span<const Vec3> corners, const MeshIndex& choice) : boxes_(boxes_of_triangles(corners)) {
    leaf_ = choice.leaf > 0 ? choice.leaf : 8;
    room_ = kMostTwice * boxes_.size();
    std::vector<std::uint32_t> own;
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) all_.include(boxes_[i]), own.push_back(i);
    nodes_.push_back({});
    build(0, own, all_, 0);
    boxes_.clear(), boxes_.shrink_to_fit();
  }
  void find(const Aabb& box, std::vector<std::uint32_t>& out) const override {
    std::uint32_t stack[kDeepest + 2];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& n = nodes_[stack[--top]];
      if (n.axis < 0) {
        out.insert(out.end(), items_.begin() + n.first, items_.begin() + n.first + n.count);
        continue;
      }
      if (box.hi[n.axis] >= n.at) stack[top++] = n.first + 1;
      if (box.lo[n.axis] <= n.at) stack[top++] = n.first;
    }
  }
  void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const override {
    struct Part {
      std::uint32_t node;
      Real from, to;
    } stack[kDeepest + 2];
    int top = 0;
    stack[top++] = {0, 0, 1};
    while (top > 0) {
      const Part p = stack[--top];
      const Node& n = nodes_[p.node];
      if (n.axis < 0) {
        out.insert(out.end(), items_.begin() + n.first, items_.begin() + n.first + n.count);
        continue;
      }
      const Real a = origin[n.axis] + p.from * ray[n.axis], b = origin[n.axis] + p.to * ray[n.axis];
      const Real room = Real(1e-5) * (std::abs(a) + std::abs(b) + std::abs(n.at));
      const bool low = std::min(a, b) <= n.at + room, high = std::max(a, b) >= n.at - room;
      if (low && high && ray[n.axis] != 0) {
        const Real t = (n.at - origin[n.axis]) / ray[n.axis], slack = Real(1e-4);
        const bool up = ray[n.axis] > 0;
        const Real before = std::min(p.to, t + slack), after = std::max(p.from, t - slack);
        stack[top++] = {n.first + (up ? 1u : 0u), after, p.to};
        stack[top++] = {n.first + (up ? 0u : 1u), p.from, before};
        continue;
      }
      if (high) stack[top++] = {n.first + 1, p.from, p.to};
      if (low) stack[top++] = {n.first, p.from, p.to};
    }
  }
  std::size_t bytes() const override { return nodes_.size() * sizeof(Node) + items_.size() * sizeof(std::uint32_t); }
  bool volumes_at(int level, EdgeVisitor visit) const override {
    struct Part {
      std::uint32_t node;
      int depth;
      Aabb box;
    };
    std::vector<Part> stack{{0, 0, all_}};
    bool more = true, deeper = false;
    while (!stack.empty()) {
      const Part p = stack.back();
      stack.pop_back();
      const Node& n = nodes_[p.node];
      if (n.axis < 0 || p.depth == level) {
        deeper |= n.axis >= 0;
        if (more) more = edges_of_box(p.box, visit);
        continue;
      }
      Part low{n.first, p.depth + 1, p.box}, high{n.first + 1, p.depth + 1, p.box};
      low.box.hi[n.axis] = high.box.lo[n.axis] = n.at;
      stack.push_back(high), stack.push_back(low);
    }
    return deeper;
  }

 private:
  struct Node {
    int axis = -1;                       // below 0: a leaf
    Real at = 0;                         // of its plane
    std::uint32_t first = 0, count = 0;  // items; else the first of two nodes
  };
  void build(std::uint32_t node, const std::vector<std::uint32_t>& own, const Aabb& box, int depth) {
    std::vector<std::uint32_t> low, high;
    if (own.size() > leaf_ && depth < kDeepest) {
      const Vec3 size = box.hi - box.lo;
      const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
      std::vector<Real> middles;
      for (const std::uint32_t i : own) middles.push_back((boxes_[i].lo[axis] + boxes_[i].hi[axis]) / 2);
      const auto half = middles.begin() + static_cast<std::ptrdiff_t>(middles.size() / 2);
      std::nth_element(middles.begin(), half, middles.end());
      const Real at = clamp(*half, box.lo[axis], box.hi[axis]);
      for (const std::uint32_t i : own) {
        if (boxes_[i].lo[axis] <= at) low.push_back(i);
        if (boxes_[i].hi[axis] >= at) high.push_back(i);
      }
      const std::size_t most = std::max(low.size(), high.size());
      const std::size_t twice = low.size() + high.size() - own.size();
      if (most < own.size() && 2 * twice <= own.size() && twice <= room_) {
        room_ -= twice;
        const auto child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[node] = {axis, at, child, 0};
        nodes_.push_back({}), nodes_.push_back({});
        Aabb below = box, above = box;
        below.hi[axis] = above.lo[axis] = at;
        build(child, low, below, depth + 1);
        build(child + 1, high, above, depth + 1);
        return;
      }
    }
    nodes_[node] = {-1, 0, static_cast<std::uint32_t>(items_.size()), static_cast<std::uint32_t>(own.size())};
    items_.insert(items_.end(), own.begin(), own.end());
  }

  std::size_t leaf_ = 8, room_ = 0;  // how many more may lie on both sides of a plane
  Aabb all_;
  std::vector<Aabb> boxes_;  // while it is built
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

}  // namespace

TriangleIndexKind geom_kd_tree() { return triangle_index<KdTreeIndex>("kd_tree", "k-d tree: triangles of many sizes"); }

}  // namespace feder
