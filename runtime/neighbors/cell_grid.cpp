// Points into cells by a counting sort (Green, "Particle Simulation using CUDA", 2008). Kept between calls: work
// arrays. Weak spot: points far apart from the rest share the cells at the rim, and one crowded cell is searched as a
// whole.
#include "neighbors/cell_grid.h"

#include <algorithm>
#include <cmath>

#include "neighbors/counting_sort.h"

namespace feder {

// The bounding box, unless it has more cells than is sensible for the points: then the longest sides are cut to a box
// about the mean.
void CellGrid::choose(std::span<const Real> p, Real cell) {
  const std::size_t count = p.size() / 4;
  double lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0}, sum[3] = {0, 0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = p[4 * i + k];
      lo[k] = i == 0 ? x : std::min(lo[k], x), hi[k] = i == 0 ? x : std::max(hi[k], x);
      sum[k] += x;
    }
  }
  inv_cell_ = 1 / cell;
  const double most = 8.0 * static_cast<double>(count) + 4096;
  double want[3];
  for (int k = 0; k < 3; ++k) want[k] = std::floor((hi[k] - lo[k]) / static_cast<double>(cell)) + 1;
  while (want[0] * want[1] * want[2] > most) {
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (want[k] > want[longest]) longest = k;
    want[longest] = std::max(1.0, std::floor(std::min(want[longest] / 2, most)));
  }
  for (int k = 0; k < 3; ++k) {
    if (!(want[k] >= 1)) want[k] = 1;
    cells_[k] = static_cast<int>(want[k]);
    const bool whole = want[k] * static_cast<double>(cell) >= hi[k] - lo[k];
    const double mean = count ? sum[k] / static_cast<double>(count) : 0;
    origin_[k] = static_cast<Real>(whole ? lo[k] : mean - want[k] * static_cast<double>(cell) / 2);
  }
}

bool CellGrid::sort(std::span<const Real> p, Real cell, Array<std::uint32_t>& order) {
  const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
  choose(p, cell);
  if (cell_.size() < count) cell_.resize(count);
  std::uint32_t before = 0;
  bool identity = true;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Real* x = &p[4 * std::size_t(i)];
    const std::uint32_t c = static_cast<std::uint32_t>(row(coordinate(1, x[1]), coordinate(2, x[2])) +
                                                       static_cast<std::size_t>(coordinate(0, x[0])));
    cell_[i] = c;
    identity = identity && c >= before;
    before = c;
  }
  counting_sort(
      count, row(0, cells_[2]), [&](std::uint32_t i) { return cell_[i]; }, start_, order);
  return identity;
}

}  // namespace feder
