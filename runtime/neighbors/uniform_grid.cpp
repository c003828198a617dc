// Uniform grid: cells as wide as the radius, points sorted by cell, so that the candidates of a point are nine runs of
// consecutive points (three in 2D). Points that come in the order of their cells need no copy and no sorting of rows,
// and those of a cell share its candidates, which are set out as columns once. Source: Green, "Particle Simulation
// using CUDA" (2008), counting sort by cell. Kept between calls: work arrays. Weak spot: radii that differ by particle.
#include "bounds/cell_grid.h"
#include "neighbors/near_run.h"
#include "neighbors/rows.h"

namespace feder {
namespace {

const NearKernels& near_kernels() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return kNearAvx2;
#endif
  return kNearPlain;
}

// The candidates of the cell that a thread is at.
struct NearCell {
  Candidates candidates;
  int cell[3] = {-1, -1, -1};
  std::uint32_t own_first = 0, own_at = 0;  // the cell's row: its first point, and where it stands among the candidates
  bool whole = false;                       // all candidates have room
};

class UniformGrid final : public NeighborSearch {
 public:
  explicit UniformGrid(Arena& a) : grid_(a), order_(&a), sorted_(&a), near_(&a) {}

  void find(std::span<const Real> p, Real radius, JobPool& jobs, NeighborLists& out) override {
    const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
    const bool identity = grid_.sort(p, radius, jobs, order_);
    const Real* x = p.data();
    if (!identity) {
      sorted_.resize(p.size());
      for (std::uint32_t k = 0; k < count; ++k)
        for (std::size_t c = 0; c < 4; ++c) sorted_[4 * std::size_t(k) + c] = p[4 * std::size_t(order_[k]) + c];
      x = sorted_.data();
    }
    const Real near2 = radius * radius;
    const NearKernels& kernels = near_kernels();
    if (near_.size() < static_cast<std::size_t>(jobs.threads())) near_.resize(static_cast<std::size_t>(jobs.threads()));
    for (NearCell& c : near_) c.cell[0] = -1;
    fill_rows(count, jobs, out, identity, [&](std::uint32_t i, auto& sink, int worker) {
      const Real* own = &p[4 * std::size_t(i)];
      const int cell[3] = {grid_.coordinate(0, own[0]), grid_.coordinate(1, own[1]), grid_.coordinate(2, own[2])};
      if constexpr (std::is_same_v<std::remove_reference_t<decltype(sink)>, RowSink>) {
        NearCell& c = near_[static_cast<std::size_t>(worker)];
        if (identity && (!std::equal(cell, cell + 3, c.cell))) collect(x, cell, kernels, c);
        if (identity && c.whole) {
          sink.n = kernels.choose(c.candidates, own, near2, c.own_at + i - c.own_first, sink.out, sink.capacity);
          return;
        }
      }
      each_run(cell, [&](std::uint32_t first, std::uint32_t last, int, int) {
        for (std::uint32_t k = first; k < last; ++k) {
          const Real* q = x + 4 * std::size_t(k);
          const Real dx = q[0] - own[0], dy = q[1] - own[1], dz = q[2] - own[2];
          const std::uint32_t j = identity ? k : order_[k];
          sink.take(j, (dx * dx + dy * dy + dz * dz < near2) & (j != i));
        }
      });
    });
  }

 private:
  // Calls f(first, last, y, z) for the points of the cells around `cell`, row by row.
  template <class F>
  void each_run(const int (&cell)[3], F&& f) const {
    const int x0 = std::max(cell[0] - 1, 0), x1 = std::min(cell[0] + 1, grid_.cells(0) - 1);
    for (int z = std::max(cell[2] - 1, 0); z <= std::min(cell[2] + 1, grid_.cells(2) - 1); ++z)
      for (int y = std::max(cell[1] - 1, 0); y <= std::min(cell[1] + 1, grid_.cells(1) - 1); ++y)
        f(grid_.first(x0, y, z), grid_.last(x1, y, z), y, z);
  }

  void collect(const Real* x, const int (&cell)[3], const NearKernels& kernels, NearCell& out) const {
    std::copy(cell, cell + 3, out.cell);
    std::uint32_t total = 0;
    each_run(cell, [&](std::uint32_t first, std::uint32_t last, int, int) { total += last - first; });
    out.candidates.count = 0;
    out.whole = total <= Candidates::kRoom;
    if (!out.whole) return;
    each_run(cell, [&](std::uint32_t first, std::uint32_t last, int y, int z) {
      if (y == cell[1] && z == cell[2]) out.own_first = first, out.own_at = out.candidates.count;
      kernels.collect(x, first, last, out.candidates);
    });
  }

  CellGrid grid_;
  Array<std::uint32_t> order_;
  Array<Real> sorted_;
  Array<NearCell> near_;  // by worker
};

}  // namespace

Variant<NeighborSearch> neighbors_uniform_grid() {
  return variant_of<NeighborSearch, UniformGrid>("grid", "uniform grid, counting sort by cell");
}

}  // namespace feder
