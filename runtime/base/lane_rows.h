// Rows of four numbers (three and a weight) of eight points, gathered into lanes and scattered back. Included by
// kernels that are compiled twice, as base/simd.h says.
#pragma once
#include "base/simd.h"

namespace feder {
namespace lanes {
namespace {

constexpr WideReal kTiny = 1e-30f;

struct Rows8 {
  Lanes3 v;
  Lanes w;
};

typedef WideReal Half __attribute__((vector_size(4 * sizeof(WideReal))));

// Eight rows of four numbers, to columns.
[[gnu::always_inline]] inline Rows8 gather(const WideReal* rows, const unsigned* index) {
  Half r[kLanes];
  for (int i = 0; i < kLanes; ++i)
    __builtin_memcpy(&r[i], __builtin_assume_aligned(rows + index[i] * 4, sizeof(Half)), sizeof(Half));
  Lanes p[4];
  for (int i = 0; i < 4; ++i) p[i] = __builtin_shufflevector(r[i], r[i + 4], 0, 1, 2, 3, 4, 5, 6, 7);
  const Lanes t0 = __builtin_shufflevector(p[0], p[1], 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t1 = __builtin_shufflevector(p[0], p[1], 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes t2 = __builtin_shufflevector(p[2], p[3], 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t3 = __builtin_shufflevector(p[2], p[3], 2, 10, 3, 11, 6, 14, 7, 15);
  return {{__builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13),
           __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15),
           __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13)},
          __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15)};
}

[[gnu::always_inline]] inline void scatter(WideReal* rows, const unsigned* index, const Rows8& a) {
  const Lanes t0 = __builtin_shufflevector(a.v.x, a.v.y, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t1 = __builtin_shufflevector(a.v.x, a.v.y, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes t2 = __builtin_shufflevector(a.v.z, a.w, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t3 = __builtin_shufflevector(a.v.z, a.w, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes p[4] = {__builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13),
                      __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15),
                      __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13),
                      __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15)};
  for (int i = 0; i < 4; ++i) {
    const Half low = __builtin_shufflevector(p[i], p[i], 0, 1, 2, 3),
               high = __builtin_shufflevector(p[i], p[i], 4, 5, 6, 7);
    __builtin_memcpy(__builtin_assume_aligned(rows + index[i] * 4, sizeof(Half)), &low, sizeof(Half));
    __builtin_memcpy(__builtin_assume_aligned(rows + index[i + 4] * 4, sizeof(Half)), &high, sizeof(Half));
  }
}

// 1/x where x > 0, else 0.
[[gnu::always_inline]] inline Lanes reciprocal_or_zero(Lanes x) {
  const LaneMask good = x > all_lanes(kTiny);
  return select(good, all_lanes(1) / select(good, x, all_lanes(1)), zero_lanes());
}

}  // namespace
}  // namespace lanes
}  // namespace feder
