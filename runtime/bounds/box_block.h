// One box against four, compared together.
#pragma once
#include <cstring>

#include "feder/types.h"

namespace feder {

struct BoxBlock {   // four boxes; unused: of NaN, which overlaps nothing
  Real side[6][4];  // x from, x to, y from ...
  void put(int k, const Aabb& box) {
    for (int d = 0; d < 3; ++d) side[2 * d][k] = box.lo[d], side[2 * d + 1][k] = box.hi[d];
  }
};

using BoxSides [[gnu::vector_size(4 * sizeof(Real))]] = Real;

struct BoxAround {  // one box, four times
  explicit BoxAround(const Aabb& b) {
    for (int d = 0; d < 3; ++d) lo[d] = BoxSides{} + b.lo[d], hi[d] = BoxSides{} + b.hi[d];
  }
  BoxSides lo[3], hi[3];
};

// A bit each for those of the four that overlap the one.
inline unsigned overlapping(const BoxBlock& four, const BoxAround& box) {
  auto overlap = BoxSides{} == BoxSides{};
  for (int d = 0; d < 3; ++d) {
    BoxSides lo, hi;
    std::memcpy(&lo, four.side[2 * d], sizeof lo), std::memcpy(&hi, four.side[2 * d + 1], sizeof hi);
    overlap &= (lo <= box.hi[d]) & (hi >= box.lo[d]);
  }
#if defined(__SSE__) && !defined(FEDER_REAL_DOUBLE)
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<BoxSides>(overlap)));
#else
  unsigned bits = 0;
  for (unsigned k = 0; k < 4; ++k) bits |= static_cast<unsigned>(overlap[k] & 1) << k;
  return bits;
#endif
}

}  // namespace feder
