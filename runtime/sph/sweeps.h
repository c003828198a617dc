// Sums over neighbours, eight neighbours at a time. Every particle gathers from its own list, so a sum never depends on
// threads. A pair term is the same product of the same numbers from both sides but for its sign, so pair forces cancel
// to the rounding of the sums. Lists are padded to whole lanes with the index of a point far away, where every kernel
// is zero. Included by files compiled twice: no std, no Eigen.
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

// A vector sum for each particle of [first, last): add(i, own, at, sum) adds the terms of eight neighbours to particle
// i, whose row is `own`.
template <class F>
[[gnu::always_inline]] inline void sum_vectors(const SweepInput& s, unsigned first, unsigned last, WideReal* out4,
                                               F&& add) {
  for (unsigned i = first; i < last; ++i) {
    const Four own = spread(s.points + 4ul * i);
    Sum3 sum;
    each_eight(s, i, [&](const unsigned* at) { add(i, own, at, sum); });
    out4[4ul * i] = total(sum.x), out4[4ul * i + 1] = total(sum.y), out4[4ul * i + 2] = total(sum.z),
               out4[4ul * i + 3] = 0;
  }
}

// Density, gradient and viscosity may come from different kernels; pressure that is the gradient of an energy needs
// the first two to be one.
template <class Density, class Gradient, class Laplacian>
struct SweepsOf {
  static void values(const SweepInput& s, unsigned first, unsigned last, WideReal* out) {
    const Lanes inv = all_lanes(s.inv_support);
    for (unsigned i = first; i < last; ++i) {
      const Four own = spread(s.points + 4ul * i);
      Lanes sum = zero_lanes();
      each_eight(s, i, [&](const unsigned* at) { sum += Density::value(pair(own, gather(s.points, at), inv).u); });
      out[i] = total(sum);
    }
  }

  static void slopes(const SweepInput& s, unsigned first, unsigned last, WideReal* out4, WideReal* squares) {
    const Lanes inv = all_lanes(s.inv_support);
    for (unsigned i = first; i < last; ++i) {
      const Four own = spread(s.points + 4ul * i);
      Lanes sum = zero_lanes(), x = sum, y = sum, z = sum, square = sum;
      each_eight(s, i, [&](const unsigned* at) {
        const Pair p = pair(own, gather(s.points, at), inv);
        const Lanes g = Gradient::slope(p.u), gu = g * p.u;
        sum += Density::value(p.u);
        x += g * p.x, y += g * p.y, z += g * p.z;
        square += gu * gu;
      });
      out4[4ul * i] = total(x), out4[4ul * i + 1] = total(y), out4[4ul * i + 2] = total(z),
                 out4[4ul * i + 3] = total(sum);
      squares[i] = total(square);
    }
  }

  static void push(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support);
    sum_vectors(s, first, last, out4, [&](unsigned, const Four& own, const unsigned* at, Sum3& sum) {
      const Four other = gather(s.points, at);
      const Pair p = pair(own, other, inv);
      const Lanes f = Gradient::slope(p.u) * (own.w + other.w);
      sum.x += f * p.x, sum.y += f * p.y, sum.z += f * p.z;
    });
  }

  static void push_from(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support);
    sum_vectors(s, first, last, out4, [&](unsigned i, const Four& own, const unsigned* at, Sum3& sum) {
      const Four y0 = spread(s.velocity + 4ul * i);
      const Four other = gather(s.points, at), y1 = gather(s.velocity, at);
      const Pair p = pair(own, other, inv);
      const Lanes f = Gradient::slope(p.u) * (own.w + other.w);
      sum.x += f * (y0.x - y1.x), sum.y += f * (y0.y - y1.y), sum.z += f * (y0.z - y1.z);
    });
  }

  // Artificial viscosity of Monaghan 1992: only between particles that approach.
  static void push_damped(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support), soft = all_lanes(s.soft), damp = all_lanes(s.damping);
    sum_vectors(s, first, last, out4, [&](unsigned i, const Four& own, const unsigned* at, Sum3& sum) {
      const Four v = spread(s.velocity + 4ul * i);
      const Four other = gather(s.points, at), vo = gather(s.velocity, at);
      const Pair p = pair(own, other, inv);
      const Lanes closing = (v.x - vo.x) * p.x + (v.y - vo.y) * p.y + (v.z - vo.z) * p.z;
      const Lanes r2 = p.x * p.x + p.y * p.y + p.z * p.z;
      const Lanes f = Gradient::slope(p.u) * ((own.w + other.w) - damp * min(closing, zero_lanes()) / (r2 + soft));
      sum.x += f * p.x, sum.y += f * p.y, sum.z += f * p.z;
    });
  }

  // Cohesion of Akinci, Akinci & Teschner 2013, eq. 2: attraction that is 1, its maximum, at half the support, and
  // repulsion close by.
  static void cohere(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support), tiny = all_lanes(WideReal(1e-3));
    sum_vectors(s, first, last, out4, [&](unsigned, const Four& own, const unsigned* at, Sum3& sum) {
      const Pair p = pair(own, gather(s.points, at), inv);
      const Lanes a = (all_lanes(1) - p.u) * p.u, a3 = all_lanes(64) * a * a * a;
      const Lanes near = min(a3 - all_lanes(1), zero_lanes());  // below half the support: twice, less one
      const LaneMask close = p.u < all_lanes(WideReal(0.5));
      const Lanes f = (a3 + select(close, near, zero_lanes())) / max(p.u, tiny);
      sum.x += f * p.x, sum.y += f * p.y, sum.z += f * p.z;
    });
  }

  static void viscous(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support), soft = all_lanes(s.soft);
    sum_vectors(s, first, last, out4, [&](unsigned i, const Four& own, const unsigned* at, Sum3& sum) {
      const Four v = spread(s.velocity + 4ul * i);
      const Four vo = gather(s.velocity, at);
      const Pair p = pair(own, gather(s.points, at), inv);
      const Lanes vx = v.x - vo.x, vy = v.y - vo.y, vz = v.z - vo.z;
      Laplacian::add(p, vx, vy, vz, soft, sum.x, sum.y, sum.z);
    });
  }

  static void growth(const SweepInput& s, unsigned first, unsigned last, WideReal* out) {
    const Lanes inv = all_lanes(s.inv_support);
    for (unsigned i = first; i < last; ++i) {
      const Four own = spread(s.points + 4ul * i), v = spread(s.velocity + 4ul * i);
      Lanes sum = zero_lanes();
      each_eight(s, i, [&](const unsigned* at) {
        const Pair p = pair(own, gather(s.points, at), inv);
        const Four vo = gather(s.velocity, at);
        sum += Gradient::slope(p.u) * ((v.x - vo.x) * p.x + (v.y - vo.y) * p.y + (v.z - vo.z) * p.z);
      });
      out[i] = total(sum);
    }
  }

  static constexpr Sweeps table() { return {values, slopes, push, push_damped, push_from, growth, cohere, viscous}; }
};

// Viscous pair term of Monaghan & Gingold 1983: along the line between the particles, so that it keeps angular
// momentum.
template <class Gradient>
struct RadialViscosity {
  static constexpr bool kRadial = true;
  [[gnu::always_inline]] static void add(const Pair& p, Lanes vx, Lanes vy, Lanes vz, Lanes soft, Lanes& x, Lanes& y,
                                         Lanes& z) {
    const Lanes r2 = p.x * p.x + p.y * p.y + p.z * p.z;
    const Lanes f = Gradient::slope(p.u) * (vx * p.x + vy * p.y + vz * p.z) / (r2 + soft);
    x += f * p.x, y += f * p.y, z += f * p.z;
  }
};

// That of Mueller 2003: along the velocities, by the Laplacian of a kernel of its own. It does not keep angular
// momentum.
template <class Shape>
struct PlainViscosity {
  static constexpr bool kRadial = false;
  [[gnu::always_inline]] static void add(const Pair& p, Lanes vx, Lanes vy, Lanes vz, Lanes, Lanes& x, Lanes& y,
                                         Lanes& z) {
    const Lanes f = Shape::laplacian(p.u);
    x -= f * vx, y -= f * vy, z -= f * vz;
  }
};

}  // namespace
}  // namespace feder
