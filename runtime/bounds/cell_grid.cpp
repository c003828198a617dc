// Points into cells by a counting sort (Green, "Particle Simulation using CUDA", 2008). Kept between calls: work
// arrays. Weak spot: points far apart from the rest share the cells at the rim, and one crowded cell is searched as a
// whole.
#include "bounds/cell_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bounds/counting_sort.h"

namespace feder {

namespace {

constexpr JobGrain kPoints{4096, 15'000};

}  // namespace

// The bounding box, unless it has more cells than is sensible for the points: then the longest sides are cut to a box
// about the mean.
void CellGrid::choose(std::span<const Real> p, Real cell, JobPool& jobs) {
  const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
  blocks_.resize((count + kPoints.items - 1) / kPoints.items);
  jobs.for_blocks(count, kPoints, [&](std::uint32_t first, std::uint32_t last, int) {
    Real least[4], most[4];
    for (std::size_t k = 0; k < 4; ++k) least[k] = most[k] = p[4 * std::size_t(first) + k];
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t k = 0; k < 4; ++k) {
        const Real x = p[4 * i + k];
        least[k] = std::min(least[k], x), most[k] = std::max(most[k], x);
      }
    BlockBounds& b = blocks_[first / kPoints.items];
    std::copy(least, least + 4, b.lo), std::copy(most, most + 4, b.hi);
  });
  double lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k)
    for (const BlockBounds& b : blocks_) {
      const double least = b.lo[k], most = b.hi[k];
      lo[k] = &b == blocks_.data() ? least : std::min(lo[k], least);
      hi[k] = &b == blocks_.data() ? most : std::max(hi[k], most);
    }
  inv_cell_ = 1 / cell;
  const auto most = static_cast<double>(most_cells(count));
  double want[3];
  for (int k = 0; k < 3; ++k) {
    want[k] = std::floor((hi[k] - lo[k]) / static_cast<double>(cell)) + 1;
    // points that went non-finite within a step are taken out at its end
    if (!std::isfinite(want[k])) want[k] = want[k] > 0 ? 2 * most : 1;
  }
  while (want[0] * want[1] * want[2] > most) {
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (want[k] > want[longest]) longest = k;
    want[longest] = std::max(1.0, std::floor(std::min(want[longest] / 2, most)));
  }
  for (int k = 0; k < 3; ++k) {
    if (!(want[k] >= 1)) want[k] = 1;
    cells_[k] = static_cast<int>(want[k]);
    origin_[k] = static_cast<Real>(lo[k]);
    if (want[k] * static_cast<double>(cell) >= hi[k] - lo[k]) continue;
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(p[4 * i + static_cast<std::size_t>(k)]);
    const double mean = count ? sum / static_cast<double>(count) : 0;
    origin_[k] = static_cast<Real>(mean - want[k] * static_cast<double>(cell) / 2);
  }
}

// True when the cells of the points ascend.
bool CellGrid::number_cells(std::span<const Real> p, JobPool& jobs) {
  const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
  if (cell_.size() < count) cell_.resize(count);
  jobs.for_blocks(count, kPoints, [&](std::uint32_t first, std::uint32_t last, int) {
    std::uint32_t before = 0;
    bool ascending = true;
    for (std::uint32_t i = first; i < last; ++i) {
      const Real* x = &p[4 * std::size_t(i)];
      const std::uint32_t c = static_cast<std::uint32_t>(row(coordinate(1, x[1]), coordinate(2, x[2])) +
                                                         static_cast<std::size_t>(coordinate(0, x[0])));
      cell_[i] = c;
      ascending = ascending && c >= before;
      before = c;
    }
    blocks_[first / kPoints.items].ascending = ascending;
  });
  bool ascending = true;
  for (std::uint32_t i = 0; i < count; i += kPoints.items)
    ascending = ascending && blocks_[i / kPoints.items].ascending && (i == 0 || cell_[i] >= cell_[i - 1]);
  return ascending;
}

// Where the cells ascend: each point that is the first of its cell begins it, and the empty ones before it.
void CellGrid::fill_identity(std::uint32_t count, std::size_t keys, JobPool& jobs, Array<std::uint32_t>& order) {
  start_.resize(keys + 1), order.resize(count);
  jobs.for_blocks(count, kPoints, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      order[i] = i;
      for (std::size_t c = i == 0 ? 0 : std::size_t(cell_[i - 1]) + 1; c <= cell_[i]; ++c) start_[c] = i;
    }
  });
  const std::size_t used = count > 0 ? std::size_t(cell_[count - 1]) + 1 : 0;
  std::fill(start_.begin() + static_cast<std::ptrdiff_t>(used), start_.end(), count);
}

// Counting sort in parts, one for each thread: those of a cell stand in the order of the parts, so their number does
// not show.
void CellGrid::sort_by_number(std::uint32_t count, std::size_t keys, JobPool& jobs, Array<std::uint32_t>& order) {
  const auto parts = static_cast<std::uint32_t>(std::min(jobs.threads(), 8));
  if (parts == 1 || count < 4 * kPoints.items || keys > count) {
    counting_sort(
        count, keys, [&](std::uint32_t i) { return cell_[i]; }, start_, order);
    return;
  }
  const JobGrain grain{1, count / parts * 2};
  const auto first_of = [&](std::uint32_t part) {
    return static_cast<std::uint32_t>(std::uint64_t(count) * part / parts);
  };
  start_.resize(keys + 1), order.resize(count);
  if (starts_.size() < parts * keys) starts_.resize(parts * keys);
  jobs.for_blocks(parts, grain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t part = first; part < last; ++part) {
      std::uint32_t* start = starts_.data() + part * keys;
      std::fill(start, start + keys, 0u);
      for (std::uint32_t i = first_of(part); i < first_of(part + 1); ++i) ++start[cell_[i]];
    }
  });
  std::uint32_t total = 0;
  for (std::size_t c = 0; c < keys; ++c) {
    start_[c] = total;
    for (std::uint32_t part = 0; part < parts; ++part) total += std::exchange(starts_[part * keys + c], total);
  }
  start_[keys] = total;
  jobs.for_blocks(parts, grain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t part = first; part < last; ++part) {
      std::uint32_t* start = starts_.data() + part * keys;
      for (std::uint32_t i = first_of(part); i < first_of(part + 1); ++i) order[start[cell_[i]]++] = i;
    }
  });
}

bool CellGrid::sort(std::span<const Real> p, Real cell, JobPool& jobs, Array<std::uint32_t>& order) {
  const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
  choose(p, cell, jobs);
  const bool identity = number_cells(p, jobs);
  const std::size_t keys = row(0, cells_[2]);
  identity ? fill_identity(count, keys, jobs, order) : sort_by_number(count, keys, jobs, order);
  return identity;
}

}  // namespace feder
