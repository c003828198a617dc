// Neighbour search: which points are nearer than a radius. Knows no particles, fluids or world.
#pragma once
#include <span>

#include "base/jobs.h"
#include "base/registry.h"
#include "feder/memory.h"

namespace feder {

// Rows of neighbours, `stride` apart; what follows the last of a row up to whole lanes of eight is filled with the
// number of points, the index of nobody.
struct NeighborLists {
  explicit NeighborLists(Arena& a) : index(&a), count(&a), rounded(&a) {}
  static constexpr std::uint32_t kMaxNeighbors = 256;  // neighbours in a row

  Array<std::uint32_t> index;
  Array<std::uint32_t> count;    // neighbours of a point
  Array<std::uint32_t> rounded;  // likewise, in whole lanes
  std::uint32_t stride = 40;
  std::span<const std::uint32_t> row(std::uint32_t i) const {
    return {index.data() + std::size_t(i) * stride, count[i]};
  }
};

// Contract, checked for every row of the table by tests/neighbors/test_neighbor_contract.cpp:
//  - the row of i holds each j != i with |x_i - x_j| < radius once, ascending, as brute force finds them;
//  - equal points give equal lists, whatever was asked before and for any number of threads;
//  - a point with more than kMaxNeighbors neighbours keeps an even choice of them; j is in the row of i when i is in
//  that of j.
// Points are x, y, z and a fourth number that is ignored; all finite. Allocates only when points or neighbours
// outnumber every earlier call.
class NeighborSearch {
 public:
  virtual ~NeighborSearch() = default;
  virtual void find(std::span<const Real> points4, Real radius, JobPool& jobs, NeighborLists& out) = 0;
};

std::span<const Variant<NeighborSearch>> neighbor_searches();

}  // namespace feder
