// Pairs of a particle and eight neighbours. Included by files compiled twice: no std, no Eigen.
#pragma once
#include "sph/shapes.h"
#include "sph/sweep_table.h"

namespace feder {
namespace {

typedef WideReal Row4 __attribute__((vector_size(4 * sizeof(WideReal))));
typedef unsigned Uint8Lanes __attribute__((vector_size(8 * sizeof(unsigned))));

struct Four {
  Lanes x, y, z, w;
};

[[gnu::always_inline]] inline Row4 row4(const WideReal* from) {
  Row4 r;
  __builtin_memcpy(&r, from, sizeof r);
  return r;
}
[[gnu::always_inline]] inline Lanes join(const WideReal* a, const WideReal* b) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  return reinterpret_cast<Lanes>(_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(a)), _mm_loadu_ps(b), 1));
#else
  return __builtin_shufflevector(row4(a), row4(b), 0, 1, 2, 3, 4, 5, 6, 7);
#endif
}

// Eight rows of four numbers, as columns.
[[gnu::always_inline]] inline Four gather(const WideReal* rows, const unsigned* at) {
  const Lanes t0 = join(rows + 4ul * at[0], rows + 4ul * at[4]), t1 = join(rows + 4ul * at[1], rows + 4ul * at[5]);
  const Lanes t2 = join(rows + 4ul * at[2], rows + 4ul * at[6]), t3 = join(rows + 4ul * at[3], rows + 4ul * at[7]);
  const Lanes a = __builtin_shufflevector(t0, t1, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes b = __builtin_shufflevector(t0, t1, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes c = __builtin_shufflevector(t2, t3, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes d = __builtin_shufflevector(t2, t3, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15)};
}
[[gnu::always_inline]] inline Four spread(const WideReal* row) {
  return {all_lanes(row[0]), all_lanes(row[1]), all_lanes(row[2]), all_lanes(row[3])};
}
[[gnu::always_inline]] inline WideReal total(Lanes s) {
  return ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7]));
}

// Offset to eight neighbours (own position minus theirs) and its length over the support.
struct Pair {
  Lanes x, y, z, u;
};
[[gnu::always_inline]] inline Pair pair(const Four& own, const Four& other, Lanes inv_support) {
  const Lanes x = own.x - other.x, y = own.y - other.y, z = own.z - other.z;
  return {x, y, z, min(square_root(x * x + y * y + z * z) * inv_support, all_lanes(1))};
}

template <class F>
[[gnu::always_inline]] inline void each_eight(const SweepInput& s, unsigned i, F&& f) {
  const unsigned* at = s.neighbors + static_cast<unsigned long>(i) * s.stride;
  for (const unsigned* end = at + s.rounded[i]; at != end; at += kLanes) f(at);
}

struct Sum3 {
  Lanes x = zero_lanes(), y = x, z = x;
};

}  // namespace
}  // namespace feder
