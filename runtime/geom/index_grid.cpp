// Uniform grid over the box of the mesh, about two cells per triangle; each triangle lies in all cells that its box
// meets, and is found in the first of those that the query meets as well, so once. For triangles of one
// size that fill their space evenly; a few large ones among many small ones lie in many cells, those far apart leave
// them empty. `leaf`: triangles per cell that are aimed at. Source: Ericson, "Real-Time Collision Detection"
// (2005), 7.1.
#include <algorithm>
#include <cmath>

#include "bounds/segment_box.h"
#include "geom/mesh_index.h"

namespace feder {
namespace {

constexpr double kMostCells = 4e6, kLongest = 512;  // cells, in all and along an axis

class GridIndex final : public TriangleIndex {
 public:
  GridIndex(std::span<const Vec3> corners, const MeshIndex& choice) {
    const std::vector<Aabb> boxes = boxes_of_triangles(corners);
    for (const Aabb& b : boxes) all_.include(b);
    choose_cells(static_cast<double>(boxes.size()) / std::max<double>(choice.leaf, 0.5));
    const auto cells =
        static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]);
    first_.assign(cells + 1, 0);
    const auto each_cell = [&](const Aabb& box, auto&& f) {
      int lo[3], hi[3];
      cells_of(box, lo, hi);
      for (int z = lo[2]; z <= hi[2]; ++z)
        for (int y = lo[1]; y <= hi[1]; ++y)
          for (int x = lo[0]; x <= hi[0]; ++x) f(cell(x, y, z));
    };
    for (const Aabb& b : boxes) each_cell(b, [&](std::size_t c) { ++first_[c + 1]; });
    for (std::size_t c = 0; c < cells; ++c) first_[c + 1] += first_[c];
    items_.resize(first_[cells]);
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < boxes.size(); ++i) each_cell(boxes[i], [&](std::size_t c) { items_[next[c]++] = i; });
    for (const Aabb& b : boxes) {
      int lo[3], hi[3];
      cells_of(b, lo, hi);
      begin_.push_back({std::uint16_t(lo[0]), std::uint16_t(lo[1]), std::uint16_t(lo[2])});
    }
  }

  void find(const Aabb& box, std::vector<std::uint32_t>& out) const override {
    if (!overlaps(box, all_)) return;
    int lo[3], hi[3];
    cells_of(box, lo, hi);
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y)
        for (int x = lo[0]; x <= hi[0]; ++x) {
          const std::size_t c = cell(x, y, z);
          for (std::uint32_t k = first_[c]; k < first_[c + 1]; ++k) {
            const Cell& from = begin_[items_[k]];
            if (std::max<int>(from.x, lo[0]) == x && std::max<int>(from.y, lo[1]) == y &&
                std::max<int>(from.z, lo[2]) == z)
              out.push_back(items_[k]);
          }
        }
  }
  // Slab by slab along the axis of most cells: of each the cells that the ray may meet.
  void find_ray(const Vec3& origin, const Vec3& ray, std::vector<std::uint32_t>& out) const override {
    Aabb whole = all_;
    whole.grow(Real(1e-5) * length(Vec3(all_.hi - all_.lo)));
    if (!segment_hits(whole, origin, ray)) return;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(ray[k]) * width_inv_[k] > std::abs(ray[axis]) * width_inv_[axis]) axis = k;
    const auto at = [&](Real t, int k) { return origin[k] + t * ray[k]; };
    for (int s = 0; s < size_[axis]; ++s) {
      Real from = 0, to = 1;
      if (ray[axis] != 0 && width_inv_[axis] > 0) {
        const Real a = (all_.lo[axis] + Real(s) / width_inv_[axis] - origin[axis]) / ray[axis],
                   b = (all_.lo[axis] + Real(s + 1) / width_inv_[axis] - origin[axis]) / ray[axis];
        from = std::max(from, std::min(a, b) - Real(1e-4)), to = std::min(to, std::max(a, b) + Real(1e-4));
        if (from > to) continue;
      }
      Aabb part;
      for (int k = 0; k < 3; ++k)
        part.lo[k] = std::min(at(from, k), at(to, k)), part.hi[k] = std::max(at(from, k), at(to, k));
      part.grow(Real(1e-5) * length(Vec3(all_.hi - all_.lo)));
      find(part, out);
    }
  }
  std::size_t bytes() const override {
    return (first_.size() + items_.size()) * sizeof(std::uint32_t) + begin_.size() * sizeof(Cell);
  }
  // The whole, then the cells with triangles in them.
  bool volumes_at(int level, EdgeVisitor visit) const override {
    if (level == 0 || first_.size() < 3) return edges_of_box(all_, visit), first_.size() > 2;
    for (int z = 0; z < size_[2]; ++z)
      for (int y = 0; y < size_[1]; ++y)
        for (int x = 0; x < size_[0]; ++x) {
          const std::size_t c = cell(x, y, z);
          if (first_[c] == first_[c + 1]) continue;
          const int at[3] = {x, y, z};
          Aabb box = all_;
          for (int k = 0; k < 3; ++k)
            if (width_inv_[k] > 0)
              box.lo[k] = all_.lo[k] + Real(at[k]) / width_inv_[k],
              box.hi[k] = all_.lo[k] + Real(at[k] + 1) / width_inv_[k];
          if (!edges_of_box(box, visit)) return false;
        }
    return false;
  }

 private:
  struct Cell {
    std::uint16_t x, y, z;
  };
  void choose_cells(double wanted) {
    const Vec3 extent = all_.hi - all_.lo;
    const double longest = static_cast<double>(extent.maxCoeff());
    double side[3], held = 1;
    for (int k = 0; k < 3; ++k) {  // flat meshes have one layer
      side[k] = std::max(static_cast<double>(extent[k]), longest * 1e-3);
      held *= side[k];
    }
    const double edge = std::cbrt(held / std::clamp(wanted, 1.0, kMostCells / 8));
    for (int k = 0; k < 3; ++k) {
      size_[k] = longest > 0 ? static_cast<int>(std::clamp(std::ceil(side[k] / edge), 1.0, kLongest)) : 1;
      width_inv_[k] = extent[k] > 0 ? Real(size_[k]) / extent[k] : Real(0);
    }
    while (double(size_[0]) * size_[1] * size_[2] > kMostCells)
      for (int k = 0; k < 3; ++k) {
        size_[k] = std::max(1, size_[k] / 2);
        width_inv_[k] = extent[k] > 0 ? Real(size_[k]) / extent[k] : Real(0);
      }
  }
  void cells_of(const Aabb& box, int* lo, int* hi) const {
    for (int k = 0; k < 3; ++k) {
      const auto place = [&](Real x) {
        const Real c = (x - all_.lo[k]) * width_inv_[k];
        return !(c > 0) ? 0 : c >= Real(size_[k]) ? size_[k] - 1 : static_cast<int>(c);
      };
      lo[k] = place(box.lo[k]), hi[k] = place(box.hi[k]);
    }
  }
  std::size_t cell(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size_[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(x);
  }

  Aabb all_;
  int size_[3] = {1, 1, 1};
  Real width_inv_[3] = {0, 0, 0};  // cells per m
  std::vector<std::uint32_t> first_, items_;
  std::vector<Cell> begin_;  // by triangle: its first cell
};

}  // namespace

TriangleIndexKind geom_grid() {
  return triangle_index<GridIndex>("grid", "uniform grid: even meshes of triangles of one size");
}

}  // namespace feder
