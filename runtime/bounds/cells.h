// Cubic cells without bounds, by number along each axis, and a hash of them.
#pragma once
#include <cmath>
#include <cstdint>

#include "base/cast.h"

namespace feder {

using CellNumber = std::int64_t;

// The cell of x; `inv` is 1 over the width of cells. Beyond 1e15 cells all share the last one.
inline CellNumber cell_number(double x, double inv) {
  constexpr CellNumber kRim = 1000000000000000;
  return clamped_cast<CellNumber>(std::floor(x * inv), -kRim, kRim);
}

inline std::uint64_t cell_hash(CellNumber x, CellNumber y, CellNumber z) {
  const std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull ^
                          static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full ^
                          static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ull;
  return h ^ h >> 32;
}

}  // namespace feder
