// The candidates of the points of a cell as columns, and the choice of those near a point, eight at a time. Included by
// files compiled twice, plain and with -mavx2, which give the same bits: no std, no Eigen.
#pragma once
#include "base/simd.h"

namespace feder {

struct alignas(64) Candidates {
  static constexpr unsigned kRoom = 2048;  // points; a search with more neighbours than rows hold has some 1700
  WideReal x[kRoom + kLanes], y[kRoom + kLanes], z[kRoom + kLanes];
  unsigned index[kRoom + kLanes];
  unsigned count = 0;
};

struct NearKernels {
  // Appends the points in [first, last), for which there is room; what follows them up to whole lanes lies far away.
  void (*collect)(const WideReal* points4, unsigned first, unsigned last, Candidates& out);
  // Writes the candidates nearer than the root of `near2` to `own`, but not the one at position `skip`, to `row` (room
  // for `capacity` + 1), and returns how many there are.
  unsigned (*choose)(const Candidates& from, const WideReal* own, WideReal near2, unsigned skip, unsigned* row,
                     unsigned capacity);
};
extern const NearKernels kNearPlain, kNearAvx2;

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

// Appends the indices of the lanes whose bits are set.
[[gnu::always_inline]] inline void append(const unsigned* index, unsigned bits, unsigned* row, unsigned capacity,
                                          unsigned& n) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  if (n + 8 <= capacity) {
    const __m256i at = _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompress.index[bits]));
    const __m256i all = _mm256_load_si256(reinterpret_cast<const __m256i*>(index));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(row + n), _mm256_permutevar8x32_epi32(all, at));
    n += static_cast<unsigned>(__builtin_popcount(bits));
    return;
  }
#endif
  for (; bits; bits &= bits - 1) {
    row[n < capacity ? n : capacity] = index[__builtin_ctz(bits)];
    ++n;
  }
}

[[maybe_unused]] void collect(const WideReal* p, unsigned first, unsigned last, Candidates& out) {
  unsigned n = out.count, k = first;
  for (; k + kLanes <= last; k += kLanes, n += kLanes) {
    const WideReal* r = p + 4ul * k;
    const Lanes t0 = two_rows(r, r + 16), t1 = two_rows(r + 4, r + 20), t2 = two_rows(r + 8, r + 24),
                t3 = two_rows(r + 12, r + 28);
    const Lanes a = __builtin_shufflevector(t0, t1, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes b = __builtin_shufflevector(t0, t1, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes c = __builtin_shufflevector(t2, t3, 0, 8, 1, 9, 4, 12, 5, 13);
    const Lanes d = __builtin_shufflevector(t2, t3, 2, 10, 3, 11, 6, 14, 7, 15);
    const Lanes x = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13);
    const Lanes y = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15);
    const Lanes z = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13);
    __builtin_memcpy(out.x + n, &x, sizeof x);
    __builtin_memcpy(out.y + n, &y, sizeof y);
    __builtin_memcpy(out.z + n, &z, sizeof z);
    for (unsigned l = 0; l < kLanes; ++l) out.index[n + l] = k + l;
  }
  for (; k < last; ++k, ++n)
    out.x[n] = p[4ul * k], out.y[n] = p[4ul * k + 1], out.z[n] = p[4ul * k + 2], out.index[n] = k;
  out.count = n;
  const Lanes far = all_lanes(WideReal(1e18));  // m; its square is finite
  __builtin_memcpy(out.x + n, &far, sizeof far);
  for (unsigned l = 0; l < kLanes; ++l) out.y[n + l] = out.z[n + l] = 0, out.index[n + l] = 0;
}

[[maybe_unused]] unsigned choose_near(const Candidates& from, const WideReal* own, WideReal near2, unsigned skip,
                                      unsigned* row, unsigned capacity) {
  const Lanes ox = all_lanes(own[0]), oy = all_lanes(own[1]), oz = all_lanes(own[2]), limit = all_lanes(near2);
  unsigned n = 0;
  for (unsigned k = 0; k < from.count; k += kLanes) {
    const Lanes x = load_row(from.x + k) - ox, y = load_row(from.y + k) - oy, z = load_row(from.z + k) - oz;
    const unsigned own_bit = skip - k < 8 ? 1u << (skip - k) : 0u;
    append(from.index + k, bits_of(x * x + y * y + z * z < limit) & ~own_bit, row, capacity, n);
  }
  return n;
}

}  // namespace
}  // namespace feder
