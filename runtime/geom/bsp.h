// Binary space partition of the triangles of a mesh by their own planes: what a plane cuts is split. Of a closed
// surface it knows the inside; of any, the order from back to front for an eye, which drawing of what is transparent
// needs.
#pragma once
#include <span>
#include <vector>

#include "base/double3.h"
#include "bounds/polytope.h"
#include "feder/types.h"

namespace feder {

class Bsp {
 public:
  static constexpr std::size_t kMostTriangles = 20000;  // of convex ones it takes n^2 steps to build

  // Three corners per triangle, counterclockwise from outside. SceneError beyond kMostTriangles.
  explicit Bsp(std::span<const Vec3> corners);

  // Of a closed surface; a point on a plane of it may lie on either side.
  bool inside(const Vec3& p) const;
  // A part of a triangle, three corners or more.
  struct Piece {
    std::uint32_t triangle;
    std::span<const Double3> corners;
  };
  // visit(piece): no piece hides one that comes later from the eye.
  template <class F>
  void back_to_front(const Vec3& eye, F&& visit) const {
    std::vector<std::uint32_t> stack, own;  // own: nodes whose far side is done
    const Double3 at = wide(eye);
    for (std::uint32_t n = nodes_.empty() ? kNone : 0;;) {
      if (n != kNone) {
        stack.push_back(n);
        n = nodes_[n].child[front(nodes_[n], at) ? 1 : 0];
        continue;
      }
      if (stack.empty()) return;
      n = stack.back(), stack.pop_back();
      each_piece(nodes_[n], visit);
      n = nodes_[n].child[front(nodes_[n], at) ? 0 : 1];
    }
  }
  // visit(triangle) for pieces at nodes whose planes pass through what test(normal, offset) says: -1 behind, 1 before,
  // 0 both. A triangle may come several times. `stack`: work.
  template <class Test, class F>
  void find(Test&& test, std::vector<std::uint32_t>& stack, F&& visit) const {
    stack.clear();
    if (!nodes_.empty()) stack.push_back(0);
    while (!stack.empty()) {
      const Node& n = nodes_[stack.back()];
      stack.pop_back();
      const int side = test(n.normal, n.offset);
      if (side == 0) each_piece(n, [&](const Piece& p) { visit(p.triangle); });
      if (side >= 0 && n.child[0] != kNone) stack.push_back(n.child[0]);
      if (side <= 0 && n.child[1] != kNone) stack.push_back(n.child[1]);
    }
  }

  // For drawing: visit(half-spaces) for the cells so many planes below the whole, and those above that none parts,
  // while it returns true; `around` bounds all of them. Returns whether there are deeper ones.
  template <class F>
  bool cells_at(int level, std::vector<HalfSpace> around, F&& visit) const {
    struct Step {
      std::uint32_t node;
      int depth;
      HalfSpace side;  // of the plane above it
    };
    const std::size_t outer = around.size();
    std::vector<Step> stack{{nodes_.empty() ? kNone : 0, 0, {}}};
    bool more = true, deeper = false;
    while (!stack.empty() && more) {
      const Step s = stack.back();
      stack.pop_back();
      if (s.depth > 0) around.resize(outer + static_cast<std::size_t>(s.depth) - 1), around.push_back(s.side);
      if (s.node == kNone || s.depth == level) {
        deeper |= s.node != kNone;
        more = visit(around);
        continue;
      }
      const Node& n = nodes_[s.node];
      stack.push_back({n.child[0], s.depth + 1, {-n.normal, -n.offset}});
      stack.push_back({n.child[1], s.depth + 1, {n.normal, n.offset}});
    }
    return deeper || !more;
  }

  std::size_t nodes() const { return nodes_.size(); }
  std::size_t pieces() const { return pieces_.size(); }
  std::size_t splits() const { return splits_; }  // triangles and pieces that planes have cut
  std::size_t bytes() const;

 private:
  struct Stored {
    std::uint32_t triangle, first, count;  // corners
  };
  struct Node {
    Double3 normal{0, 0, 0};
    double offset = 0;
    std::uint32_t child[2] = {kNone, kNone};  // before the plane, behind it
    std::uint32_t first = 0, count = 0;       // pieces in the plane
  };
  static bool front(const Node& n, const Double3& p) { return dot(n.normal, p) > n.offset; }
  template <class F>
  void each_piece(const Node& n, F&& visit) const {
    for (std::uint32_t k = n.first; k < n.first + n.count; ++k) {
      const Stored& s = pieces_[k];
      visit(Piece{s.triangle, {corners_.data() + s.first, s.count}});
    }
  }

  std::vector<Node> nodes_;
  std::vector<Stored> pieces_;
  std::vector<Double3> corners_;
  std::size_t splits_ = 0;
};

}  // namespace feder
