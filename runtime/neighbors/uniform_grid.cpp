// Uniform grid: cells as wide as the radius, points sorted by cell, so that the candidates of a point are nine runs of
// consecutive points (three in 2D). Points that come in the order of their cells need no copy and no sorting of rows.
// Source: Green, "Particle Simulation using CUDA" (2008), counting sort by cell.
// Kept between calls: work arrays. Weak spot: radii that differ by particle.
#include "neighbors/cell_grid.h"
#include "neighbors/near_run.h"
#include "neighbors/rows.h"

namespace feder {
namespace {

NearRun near_run_here() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return kNearRunAvx2;
#endif
  return kNearRunPlain;
}

class UniformGrid final : public NeighborSearch {
 public:
  explicit UniformGrid(Arena& a) : grid_(a), order_(&a), sorted_(&a) {}

  void find(std::span<const Real> p, Real radius, JobPool& jobs, NeighborLists& out) override {
    const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
    const bool identity = grid_.sort(p, radius, order_);
    const Real* x = p.data();
    if (!identity) {
      sorted_.resize(p.size());
      for (std::uint32_t k = 0; k < count; ++k)
        for (std::size_t c = 0; c < 4; ++c) sorted_[4 * std::size_t(k) + c] = p[4 * std::size_t(order_[k]) + c];
      x = sorted_.data();
    }
    const Real near = radius * radius;
    const NearRun run = near_run_here();
    fill_rows(count, jobs, out, identity, [&](std::uint32_t i, auto& sink) {
      const Real px = p[4 * std::size_t(i)], py = p[4 * std::size_t(i) + 1], pz = p[4 * std::size_t(i) + 2];
      const int cx = grid_.coordinate(0, px), cy = grid_.coordinate(1, py), cz = grid_.coordinate(2, pz);
      const int x0 = std::max(cx - 1, 0), x1 = std::min(cx + 1, grid_.cells(0) - 1);
      for (int z = std::max(cz - 1, 0); z <= std::min(cz + 1, grid_.cells(2) - 1); ++z)
        for (int y = std::max(cy - 1, 0); y <= std::min(cy + 1, grid_.cells(1) - 1); ++y) {
          const std::uint32_t last = grid_.last(x1, y, z);
          if constexpr (std::is_same_v<std::remove_reference_t<decltype(sink)>, RowSink>) {
            if (identity) {
              sink.n =
                  run(x, grid_.first(x0, y, z), last, x + 4 * std::size_t(i), near, i, sink.out, sink.capacity, sink.n);
              continue;
            }
          }
          for (std::uint32_t k = grid_.first(x0, y, z); k < last; ++k) {
            const Real* q = x + 4 * std::size_t(k);
            const Real dx = q[0] - px, dy = q[1] - py, dz = q[2] - pz;
            const std::uint32_t j = identity ? k : order_[k];
            sink.take(j, (dx * dx + dy * dy + dz * dz < near) & (j != i));
          }
        }
    });
  }

 private:
  CellGrid grid_;
  Array<std::uint32_t> order_;
  Array<Real> sorted_;
};

}  // namespace

Variant<NeighborSearch> neighbors_uniform_grid() {
  return variant_of<NeighborSearch, UniformGrid>("grid", "uniform grid, counting sort by cell");
}

}  // namespace feder
