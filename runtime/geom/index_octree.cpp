// Loose octree: a triangle lies in the cell of its middle on the level whose cells are just as large as its box, and
// cells are searched with a margin of half their width, so each lies in one cell whatever its place (Ulrich, "Loose
// Octrees", Game Programming Gems 2000). Meshes of triangles of many sizes in a wide space. `leaf` does not matter.
#include <algorithm>

#include "bounds/segment_box.h"
#include "geom/mesh_index.h"

namespace feder {
namespace {

constexpr int kLevels = 16;

class OctreeIndex final : public TriangleIndex {
 public:
  OctreeIndex(std::span<const Vec3> corners, const MeshIndex&) {
    const std::vector<Aabb> boxes = boxes_of_triangles(corners);
    Aabb all;
    for (const Aabb& b : boxes) all.include(b);
    Cell root;
    root.middle = all.lo + Real(0.5) * (all.hi - all.lo);
    root.half = Real(0.5) * (all.hi - all.lo).maxCoeff() * Real(1.001);
    cells_.push_back(root);
    std::vector<std::uint32_t> cell_of;
    for (const Aabb& b : boxes) cell_of.push_back(place(b));
    // counts, then numbers, by cell
    for (const std::uint32_t c : cell_of) ++cells_[c].count;
    std::uint32_t next = 0;
    for (Cell& c : cells_) c.first = next, next += c.count, c.count = 0;
    items_.resize(next);
    for (std::uint32_t i = 0; i < cell_of.size(); ++i) {
      Cell& c = cells_[cell_of[i]];
      items_[c.first + c.count++] = i;
    }
  }
  void find(const Aabb& box, std::vector<std::uint32_t>& out) const override {
    visit([&](const Aabb& loose) { return overlaps(loose, box); }, out);
  }
  void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const override {
    visit([&](const Aabb& loose) { return segment_hits(loose, origin, ray); }, out);
  }
  std::size_t bytes() const override { return cells_.size() * sizeof(Cell) + items_.size() * sizeof(std::uint32_t); }
  // The cells as they are divided; what lies in one may stand out of it by half its width.
  bool volumes_at(int level, EdgeVisitor visit) const override {
    std::vector<int> depth(cells_.size(), 0);
    bool more = true, deeper = false;
    for (std::size_t n = 0; n < cells_.size(); ++n) {
      const Cell& c = cells_[n];
      bool parted = false;
      for (const std::uint32_t child : c.child)
        if (child != kNone) depth[child] = depth[n] + 1, parted = true;
      deeper |= depth[n] > level;
      if (!more || depth[n] > level || (depth[n] < level && parted && c.count == 0)) continue;
      Aabb box{c.middle, c.middle};
      box.grow(c.half);
      more = edges_of_box(box, visit);
    }
    return deeper;
  }

 private:
  struct Cell {
    Vec3 middle = Vec3::Zero();
    Real half = 0;
    std::uint32_t child[8] = {kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone};
    std::uint32_t first = 0, count = 0;
  };
  std::uint32_t place(const Aabb& box) {
    const Vec3 middle = box.lo + Real(0.5) * (box.hi - box.lo);
    const Real size = (box.hi - box.lo).maxCoeff();
    std::uint32_t at = 0;
    for (int level = 0; level < kLevels && size < cells_[at].half; ++level) {
      const Cell own = cells_[at];
      unsigned k = 0;
      Cell below;
      below.half = own.half / 2;
      for (unsigned d = 0; d < 3; ++d) {
        const bool high = middle[d] > own.middle[d];
        k |= unsigned(high) << d;
        below.middle[d] = own.middle[d] + (high ? below.half : -below.half);
      }
      if (own.child[k] == kNone) {
        cells_[at].child[k] = static_cast<std::uint32_t>(cells_.size());
        cells_.push_back(below);
      }
      at = cells_[at].child[k];
    }
    return at;
  }
  template <class Test>
  void visit(Test&& test, std::vector<std::uint32_t>& out) const {
    std::uint32_t stack[8 * kLevels + 8];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Cell& c = cells_[stack[--top]];
      Aabb loose{c.middle, c.middle};
      loose.grow(2 * c.half * Real(1.001) + Real(1e-6) * c.middle.cwiseAbs().maxCoeff());
      if (!test(loose)) continue;
      out.insert(out.end(), items_.begin() + c.first, items_.begin() + c.first + c.count);
      for (const std::uint32_t child : c.child)
        if (child != kNone) stack[top++] = child;
    }
  }

  std::vector<Cell> cells_;
  std::vector<std::uint32_t> items_;
};

}  // namespace

TriangleIndexKind geom_octree() {
  return triangle_index<OctreeIndex>("octree", "loose octree: one cell for each triangle");
}

}  // namespace feder
