// Candidates that lie next to each other in memory, eight at a time. Included by files compiled twice, plain and with
// -mavx2, which give the same bits: no std, no Eigen.
#pragma once
#include "base/simd.h"

namespace feder {

// Appends to `row` (room for `capacity` + 1) the points in [first, last) nearer than the root of `near2` to `own`, but
// not `skip`; returns how many there are in all, counting from `n`.
using NearRun = unsigned (*)(const WideReal* points4, unsigned first, unsigned last, const WideReal* own,
                             WideReal near2, unsigned skip, unsigned* row, unsigned capacity, unsigned n);
extern const NearRun kNearRunPlain, kNearRunAvx2;

namespace {

using namespace lanes;
typedef WideReal Row4 __attribute__((vector_size(4 * sizeof(WideReal))));

[[gnu::always_inline]] inline Lanes two_rows(const WideReal* a, const WideReal* b) {
  Row4 x, y;
  __builtin_memcpy(&x, a, sizeof x);
  __builtin_memcpy(&y, b, sizeof y);
  return __builtin_shufflevector(x, y, 0, 1, 2, 3, 4, 5, 6, 7);
}

#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
// For each of the 256 masks, the indices of its set bits: what comes through is stored without a branch.
struct alignas(32) Compress {
  int index[256][8];
  constexpr Compress() : index() {
    for (int m = 0; m < 256; ++m) {
      int n = 0;
      for (int l = 0; l < 8; ++l)
        if (m >> l & 1) index[m][n++] = l;
      for (; n < 8; ++n) index[m][n] = 0;
    }
  }
};
constexpr Compress kCompress;
#endif

// Appends the lanes whose bits are set.
[[gnu::always_inline]] inline void append(unsigned k, unsigned bits, unsigned* row, unsigned capacity, unsigned& n) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  if (n + 8 <= capacity) {
    const __m256i at = _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompress.index[bits]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(row + n),
                        _mm256_add_epi32(at, _mm256_set1_epi32(static_cast<int>(k))));
    n += static_cast<unsigned>(__builtin_popcount(bits));
    return;
  }
#endif
  for (; bits; bits &= bits - 1) {
    row[n < capacity ? n : capacity] = k + static_cast<unsigned>(__builtin_ctz(bits));
    ++n;
  }
}

[[maybe_unused]] unsigned near_run(const WideReal* p, unsigned first, unsigned last, const WideReal* own,
                                   WideReal near2, unsigned skip, unsigned* row, unsigned capacity, unsigned n) {
  const Lanes ox = all_lanes(own[0]), oy = all_lanes(own[1]), oz = all_lanes(own[2]), limit = all_lanes(near2);
  unsigned k = first;
  for (; k + kLanes <= last; k += kLanes) {
    const WideReal* r = p + 4ul * k;
    const Lanes t0 = two_rows(r, r + 16), t1 = two_rows(r + 4, r + 20), t2 = two_rows(r + 8, r + 24),
                t3 = two_rows(r + 12, r + 28);
    const Lanes a = __builtin_shufflevector(t0, t1, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes b = __builtin_shufflevector(t0, t1, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes c = __builtin_shufflevector(t2, t3, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes d = __builtin_shufflevector(t2, t3, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes x = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13) - ox;
    const Lanes y = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15) - oy;
    const Lanes z = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13) - oz;
    const unsigned own_bit = skip - k < 8 ? 1u << (skip - k) : 0u;
    append(k, bits_of(x * x + y * y + z * z < limit) & ~own_bit, row, capacity, n);
  }
  for (; k < last; ++k) {
    const WideReal x = p[4ul * k] - own[0], y = p[4ul * k + 1] - own[1], z = p[4ul * k + 2] - own[2];
    row[n < capacity ? n : capacity] = k;
    n += (x * x + y * y + z * z < near2) & (k != skip);
  }
  return n;
}

}  // namespace
}  // namespace feder
