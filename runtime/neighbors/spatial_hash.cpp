// Spatial hash: cells without bounds, thrown into a table of twice as many buckets as points; each bucket's points are
// consecutive after a counting sort. Source: Teschner et al., "Optimized Spatial Hashing for Collision Detection of
// Deformable Objects", VMV 2003.
// Kept between calls: work arrays. Weak spot: buckets are scattered over memory, slower than the grid where points are
// dense; no advantage but for points in several clouds far apart.
#include "bounds/cells.h"
#include "bounds/counting_sort.h"
#include "neighbors/rows.h"

namespace feder {
namespace {

using Cell = CellNumber;

class SpatialHash final : public NeighborSearch {
 public:
  explicit SpatialHash(Arena& a) : start_(&a), order_(&a), cells_(&a) {}

  void find(std::span<const Real> p, Real radius, JobPool& jobs, NeighborLists& out) override {
    const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
    const double inv = 1 / static_cast<double>(radius);
    while (buckets_ < 2 * std::size_t(count)) buckets_ *= 2;
    cells_.resize(3 * std::size_t(count));
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        cells_[3 * std::size_t(i) + k] = cell_number(static_cast<double>(p[4 * std::size_t(i) + k]), inv);
    const auto key = [&](std::uint32_t i) { return bucket(&cells_[3 * std::size_t(i)]); };
    counting_sort(count, buckets_, key, start_, order_);

    const Real near = radius * radius;
    fill_rows(count, jobs, out, false, [&](std::uint32_t i, auto& sink, int) {
      const Real* x = &p[4 * std::size_t(i)];
      const Cell* own = &cells_[3 * std::size_t(i)];
      for (int n = 0; n < 27; ++n) {
        const Cell at[3] = {own[0] + n % 3 - 1, own[1] + n / 3 % 3 - 1, own[2] + n / 9 - 1};
        const std::size_t b = bucket(at);
        for (std::uint32_t k = start_[b]; k < start_[b + 1]; ++k) {
          const std::uint32_t j = order_[k];
          const Cell* other = &cells_[3 * std::size_t(j)];
          if (other[0] != at[0] || other[1] != at[1] || other[2] != at[2]) continue;  // another cell of that bucket
          const Real* q = &p[4 * std::size_t(j)];
          const Real dx = q[0] - x[0], dy = q[1] - x[1], dz = q[2] - x[2];
          sink.take(j, (dx * dx + dy * dy + dz * dz < near) & (j != i));
        }
      }
    });
  }

 private:
  std::size_t bucket(const Cell* c) const {
    return static_cast<std::size_t>(cell_hash(c[0], c[1], c[2])) & (buckets_ - 1);
  }

  std::size_t buckets_ = 64;
  Array<std::uint32_t> start_, order_;
  Array<Cell> cells_;
};

}  // namespace

Variant<NeighborSearch> neighbors_spatial_hash() {
  return variant_of<NeighborSearch, SpatialHash>("spatial_hash", "hash table of cells, for points in clouds far apart");
}

}  // namespace feder
