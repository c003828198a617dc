// The binary space partition as an index: the planes that a box or a ray meets. For closed, coarse meshes whose inside
// or order for drawing is asked for as well; for contacts alone the others are faster. `leaf` does not matter.
#include <algorithm>
#include <cmath>

#include "base/borrowed_list.h"
#include "geom/bsp.h"
#include "geom/mesh_index.h"

namespace feder {
namespace {

class BspIndex final : public TriangleIndex {
 public:
  BspIndex(std::span<const Vec3> corners, const MeshIndex&) : tree_(corners) {
    for (const Vec3& c : corners) size_ = std::max(size_, length(wide(c))), all_.include(c);
  }
  void find(const Aabb& box, std::vector<std::uint32_t>& out) const override {
    const auto bound = [](Real x) { return std::clamp(static_cast<double>(x), -1e30, 1e30); };
    const Double3 lo{bound(box.lo[0]), bound(box.lo[1]), bound(box.lo[2])},
        hi{bound(box.hi[0]), bound(box.hi[1]), bound(box.hi[2])};
    const Double3 middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
    search(
        [&](const Double3& n, double offset) {
          const double h = dot(n, middle) - offset;
          const double r = std::abs(n.x) * half.x + std::abs(n.y) * half.y + std::abs(n.z) * half.z + room();
          return h > r ? 1 : h < -r ? -1 : 0;
        },
        out);
  }
  void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const override {
    const Double3 from = wide(origin), to = wide(origin) + wide(ray);
    const double slack = room() + 1e-6 * length(to - from);
    search(
        [&](const Double3& n, double offset) {
          const double a = dot(n, from) - offset, b = dot(n, to) - offset;
          return std::min(a, b) > slack ? 1 : std::max(a, b) < -slack ? -1 : 0;
        },
        out);
  }
  std::size_t bytes() const override { return tree_.bytes(); }
  bool volumes_at(int level, EdgeVisitor visit) const override {
    std::vector<HalfSpace> box;
    for (int k = 0; k < 3; ++k) {
      const Double3 n{k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
      box.push_back({n, static_cast<double>(all_.hi[k])}), box.push_back({-n, -static_cast<double>(all_.lo[k])});
    }
    const double size = 2 * size_;  // corners of the box are farther away than those of triangles
    return tree_.cells_at(level, box, [&](const auto& planes) { return edges_within(planes, size, visit); });
  }
  bool back_to_front(const Vec3& eye, PieceVisitor visit, void* context) const override {
    std::vector<Vec3> corners;
    tree_.back_to_front(eye, [&](const Bsp::Piece& piece) {
      corners.clear();
      for (const Double3& c : piece.corners) corners.push_back(narrow(c));
      visit(context, piece.triangle, corners);
    });
    return true;
  }

 private:
  double room() const { return 1e-6 * size_; }
  template <class Test>
  void search(Test&& test, std::vector<std::uint32_t>& out) const {
    BorrowedList<std::uint32_t> stack;
    tree_.find(test, *stack, [&](std::uint32_t i) { out.push_back(i); });
  }
  Bsp tree_;
  double size_ = 0;
  Aabb all_;
};

}  // namespace

TriangleIndexKind geom_bsp() {
  return triangle_index<BspIndex>("bsp", "binary space partition by the triangles' planes: knows the inside");
}

}  // namespace feder
