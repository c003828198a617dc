// A grid of cubic cells over points, x fastest: cell numbers, and a counting sort of the points by cell. Points far
// from the rest are counted to the cells at the rim: two points nearer than a cell still lie in the same or in
// neighbouring cells, so a stray point costs time at most, never memory.
#pragma once
#include <span>

#include "base/jobs.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

class CellGrid {
 public:
  explicit CellGrid(Arena& a) : start_(&a), cell_(&a), starts_(&a), blocks_(&a) {}

  // Chooses the cells for these points; then order[k] is the point at position k, ties by index. True when order is the
  // identity. The same for any number of threads.
  bool sort(std::span<const Real> points4, Real cell, JobPool& jobs, Array<std::uint32_t>& order);

  // So that sort() of so many points does not allocate, wherever they are.
  void reserve(std::uint32_t count) { start_.reserve(most_cells(count) + 1), cell_.reserve(count); }

  int cells(int axis) const { return cells_[axis]; }
  Aabb cell(int x, int y, int z) const {  // those at the rim hold what lies beyond, too
    const Vec3 lo = Vec3(origin_[0], origin_[1], origin_[2]) + Vec3(Real(x), Real(y), Real(z)) / inv_cell_;
    return {lo, lo + Vec3::Constant(1 / inv_cell_)};
  }
  int coordinate(int axis, Real x) const {
    const Real t = (x - origin_[axis]) * inv_cell_;
    const Real last = static_cast<Real>(cells_[axis] - 1);
    return !(t > 0) ? 0 : t >= last ? cells_[axis] - 1 : static_cast<int>(t);  // NaN: the first
  }
  // Positions in the order of the points in the cells x0 .. x1 of a row.
  std::uint32_t first(int x0, int y, int z) const { return start_[row(y, z) + static_cast<std::size_t>(x0)]; }
  std::uint32_t last(int x1, int y, int z) const { return start_[row(y, z) + static_cast<std::size_t>(x1) + 1]; }

 private:
  static std::size_t most_cells(std::uint32_t count) { return 8 * std::size_t(count) + 4096; }
  std::size_t row(int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1]) + static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(cells_[0]);
  }
  // Of the points of a block of the loops over them.
  struct BlockBounds {
    Real lo[4], hi[4];
    bool ascending;
  };
  void choose(std::span<const Real> points4, Real cell, JobPool& jobs);
  bool number_cells(std::span<const Real> points4, JobPool& jobs);
  void fill_identity(std::uint32_t count, std::size_t keys, JobPool& jobs, Array<std::uint32_t>& order);
  void sort_by_number(std::uint32_t count, std::size_t keys, JobPool& jobs, Array<std::uint32_t>& order);

  Real origin_[3] = {0, 0, 0}, inv_cell_ = 1;
  int cells_[3] = {1, 1, 1};
  Array<std::uint32_t> start_, cell_;
  Array<std::uint32_t> starts_;  // work: by part of the points, and cell
  Array<BlockBounds> blocks_;    // work
};

}  // namespace feder
