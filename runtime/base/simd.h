// Eight lanes of Real as one value, over the vector extensions of gcc and clang. A kernel file is compiled twice,
// plain and with -mavx2 (never -mfma), and chosen at run time; every operation works lane by lane, so both give the
// same bits. Included by such files, therefore: no std, no Eigen (their inline functions could leak AVX2 code into
// the plain build), and everything here has internal linkage.
#pragma once
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
#include <immintrin.h>
#endif

namespace feder {

#ifdef FEDER_REAL_DOUBLE
using WideReal = double;  // the same as Real of feder/types.h, which kernels cannot include
using WideIndex = long long;
#else
using WideReal = float;
using WideIndex = int;
#endif

inline constexpr int kLanes = 8;

// Eight numbers in memory.
struct alignas(kLanes * sizeof(WideReal)) Lane8 {
  WideReal v[kLanes];
};
struct Lane8x3 {
  Lane8 x, y, z;
};

namespace lanes {
namespace {

typedef WideReal Lanes __attribute__((vector_size(kLanes * sizeof(WideReal))));
typedef WideIndex LaneMask __attribute__((vector_size(kLanes * sizeof(WideIndex))));

[[gnu::always_inline]] inline Lanes load(const Lane8& from) {
  Lanes x;
  __builtin_memcpy(&x, __builtin_assume_aligned(&from, sizeof x), sizeof x);
  return x;
}
[[gnu::always_inline]] inline Lanes load_row(const WideReal* from) {  // aligned to a row of eight
  Lanes x;
  __builtin_memcpy(&x, __builtin_assume_aligned(from, sizeof(WideReal) * 4), sizeof x);
  return x;
}
[[gnu::always_inline]] inline void store(Lane8& to, Lanes x) {
  __builtin_memcpy(__builtin_assume_aligned(&to, sizeof x), &x, sizeof x);
}
[[gnu::always_inline]] inline void store_row(WideReal* to, Lanes x) {
  __builtin_memcpy(__builtin_assume_aligned(to, sizeof(WideReal) * 4), &x, sizeof x);
}
[[gnu::always_inline]] inline Lanes all_lanes(WideReal x) { return Lanes{x, x, x, x, x, x, x, x}; }
[[gnu::always_inline]] inline Lanes zero_lanes() { return Lanes{}; }
[[gnu::always_inline]] inline Lanes select(LaneMask m, Lanes yes, Lanes no) { return m ? yes : no; }
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
// the same, zeros of either sign and NaN included; compilers do not see it
[[gnu::always_inline]] inline Lanes min(Lanes a, Lanes b) {
  return reinterpret_cast<Lanes>(_mm256_min_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
}
[[gnu::always_inline]] inline Lanes max(Lanes a, Lanes b) {
  return reinterpret_cast<Lanes>(_mm256_max_ps(reinterpret_cast<__m256>(a), reinterpret_cast<__m256>(b)));
}
#else
[[gnu::always_inline]] inline Lanes min(Lanes a, Lanes b) { return a < b ? a : b; }
[[gnu::always_inline]] inline Lanes max(Lanes a, Lanes b) { return a > b ? a : b; }
#endif
[[gnu::always_inline]] inline Lanes square_root(Lanes x) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  return reinterpret_cast<Lanes>(_mm256_sqrt_ps(reinterpret_cast<__m256>(x)));
#else
  for (int i = 0; i < kLanes; ++i) {
#ifdef FEDER_REAL_DOUBLE
    x[i] = __builtin_sqrt(x[i]);
#else
    x[i] = __builtin_sqrtf(x[i]);
#endif
  }
  return x;
#endif
}

// Is the mask set in some lane?
[[gnu::always_inline]] inline bool any(LaneMask m) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  return _mm256_movemask_ps(reinterpret_cast<__m256>(m)) != 0;
#else
  WideIndex sum = 0;
  for (int i = 0; i < kLanes; ++i) sum |= m[i];
  return sum != 0;
#endif
}

// The masks of lanes as bits, lane 0 first, and back.
[[gnu::always_inline]] inline unsigned bits_of(LaneMask m) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(m)));
#else
  unsigned bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= (m[i] ? 1u : 0u) << i;
  return bits;
#endif
}
[[gnu::always_inline]] inline LaneMask mask_of(unsigned bits) {
  const LaneMask each = {1, 2, 4, 8, 16, 32, 64, 128},
                 b = {WideIndex(bits), WideIndex(bits), WideIndex(bits), WideIndex(bits),
                      WideIndex(bits), WideIndex(bits), WideIndex(bits), WideIndex(bits)};
  return (b & each) != 0;
}

struct Lanes3 {
  Lanes x, y, z;
};
[[gnu::always_inline]] inline Lanes3 operator+(const Lanes3& a, const Lanes3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline Lanes3 operator*(const Lanes3& a, Lanes s) { return {a.x * s, a.y * s, a.z * s}; }
[[gnu::always_inline]] inline Lanes3 select(LaneMask m, const Lanes3& yes, const Lanes3& no) {
  return {select(m, yes.x, no.x), select(m, yes.y, no.y), select(m, yes.z, no.z)};
}
[[gnu::always_inline]] inline Lanes dot(const Lanes3& a, const Lanes3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
[[gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

[[gnu::always_inline]] inline Lanes3 load(const Lane8x3& a) { return {load(a.x), load(a.y), load(a.z)}; }
[[gnu::always_inline]] inline void store(Lane8x3& to, const Lanes3& a) {
  store(to.x, a.x), store(to.y, a.y), store(to.z, a.z);
}

// Rows to columns: lane i of r[k] becomes lane k of r[i].
[[gnu::always_inline]] inline void transpose(Lanes (&r)[kLanes]) {
  Lanes t[8], u[8];
  for (int i = 0; i < 8; i += 2) {
    t[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    t[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (int i = 0; i < 8; i += 4) {
    for (int k = 0; k < 2; ++k) {
      u[i + 2 * k] = __builtin_shufflevector(t[i + k], t[i + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      u[i + 2 * k + 1] = __builtin_shufflevector(t[i + k], t[i + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int i = 0; i < 4; ++i) {
    r[i] = __builtin_shufflevector(u[i], u[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    r[i + 4] = __builtin_shufflevector(u[i], u[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

// Eight rows x y z _ of four numbers, lane i from row index[i]: loads and shuffles, which beat gather instructions.
[[gnu::always_inline]] inline Lanes3 load_points(const WideReal* rows, const unsigned* index) {
#if defined(__AVX2__) && !defined(FEDER_REAL_DOUBLE)
  __m256 r[4];
  for (int i = 0; i < 4; ++i)
    r[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(rows + static_cast<unsigned long>(index[i]) * 4)),
                                _mm_load_ps(rows + static_cast<unsigned long>(index[i + 4]) * 4), 1);
  const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpacklo_ps(r[2], r[3]);
  const __m256 c = _mm256_unpackhi_ps(r[0], r[1]), d = _mm256_unpackhi_ps(r[2], r[3]);
  return {reinterpret_cast<Lanes>(_mm256_shuffle_ps(a, b, 0x44)),
          reinterpret_cast<Lanes>(_mm256_shuffle_ps(a, b, 0xee)),
          reinterpret_cast<Lanes>(_mm256_shuffle_ps(c, d, 0x44))};
#else
  Lane8x3 p;
  for (int i = 0; i < kLanes; ++i) {
    const WideReal* row = rows + static_cast<unsigned long>(index[i]) * 4;
    p.x.v[i] = row[0], p.y.v[i] = row[1], p.z.v[i] = row[2];
  }
  return load(p);
#endif
}

}  // namespace
}  // namespace lanes
}  // namespace feder
