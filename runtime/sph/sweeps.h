// Sums over neighbours, eight neighbours at a time. Every particle gathers from its own list, so a sum never depends on
// threads. A pair term is the same product of the same numbers from both sides but for its sign, so pair forces cancel
// to the rounding of the sums. Lists are padded to whole lanes with the index of a point far away, where every kernel
// is zero. Included by files compiled twice: no std, no Eigen.
#pragma once
#include "sph/image_sweeps.h"

namespace feder {
namespace {

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

// Weights of a pair.
struct One {
  [[gnu::always_inline]] static Lanes of(const Four&, const Four&) { return all_lanes(1); }
};
struct OfBoth {
  [[gnu::always_inline]] static Lanes of(const Four& own, const Four& other) { return own.w + other.w; }
};
struct OfOther {
  [[gnu::always_inline]] static Lanes of(const Four&, const Four& other) { return other.w; }
};
struct Difference {
  [[gnu::always_inline]] static Lanes of(const Four& own, const Four& other) { return other.w - own.w; }
};

template <class Shape, class Weight>
void values_of(const SweepInput& s, unsigned first, unsigned last, WideReal* out) {
  const Lanes inv = all_lanes(s.inv_support);
  for (unsigned i = first; i < last; ++i) {
    const Four own = spread(s.points + 4ul * i);
    Lanes sum = zero_lanes();
    each_eight(s, i, [&](const unsigned* at) {
      const Four other = gather(s.points, at);
      sum += Shape::value(pair(own, other, inv).u) * Weight::of(own, other);
    });
    out[i] = total(sum);
  }
}

template <class Shape, class Weight>
void push_of(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
  const Lanes inv = all_lanes(s.inv_support);
  sum_vectors(s, first, last, out4, [&](unsigned, const Four& own, const unsigned* at, Sum3& sum) {
    const Four other = gather(s.points, at);
    const Pair p = pair(own, other, inv);
    const Lanes f = Shape::slope(p.u) * Weight::of(own, other);
    sum.x += f * p.x, sum.y += f * p.y, sum.z += f * p.z;
  });
}

// Of the colour field, see fluid/tension.cpp: wide, so that particles that crowd fill little of it.
struct ColorShape {
  [[gnu::always_inline]] static Lanes value(Lanes u) { return all_lanes(1) - u * u; }
  [[gnu::always_inline]] static Lanes slope(Lanes u) { return select(u < all_lanes(1), all_lanes(-2), zero_lanes()); }
};

// Cohesion of Akinci, Akinci & Teschner 2013, eq. 2: attraction that is 1, its maximum, at half the support, and
// repulsion close by; over u, as a slope is.
struct CohesionShape {
  [[gnu::always_inline]] static Lanes slope(Lanes u) {
    const Lanes a = (all_lanes(1) - u) * u, a3 = all_lanes(64) * a * a * a;
    const Lanes near = min(a3 - all_lanes(1), zero_lanes());  // below half the support: twice, less one
    const LaneMask close = u < all_lanes(WideReal(0.5));
    return (a3 + select(close, near, zero_lanes())) / max(u, all_lanes(WideReal(1e-3)));
  }
};

// Density, gradient and viscosity may come from different kernels; pressure that is the gradient of an energy needs
// the first two to be one.
template <class Density, class Gradient, class Laplacian>
struct SweepsOf {
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

  static void push_near(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support), near = all_lanes(s.near);
    sum_vectors(s, first, last, out4, [&](unsigned, const Four& own, const unsigned* at, Sum3& sum) {
      const Four other = gather(s.points, at);
      const Pair p = pair(own, other, inv);
      const Lanes r = min(near * Density::value(p.u), all_lanes(2)), r2 = r * r;
      const Lanes f = Gradient::slope(p.u) * (own.w + other.w) * r2 * r2;
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

  static void squares_by(const SweepInput& s, unsigned first, unsigned last, WideReal* out) {
    const Lanes inv = all_lanes(s.inv_support);
    for (unsigned i = first; i < last; ++i) {
      const Four own = spread(s.points + 4ul * i);
      Lanes sum = zero_lanes();
      each_eight(s, i, [&](const unsigned* at) {
        const Four other = gather(s.points, at);
        const Pair p = pair(own, other, inv);
        const Lanes gu = Gradient::slope(p.u) * p.u;
        sum += other.w * gu * gu;
      });
      out[i] = total(sum);
    }
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

  static void viscous_by(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support), soft = all_lanes(s.soft), tiny = all_lanes(WideReal(1e-30));
    sum_vectors(s, first, last, out4, [&](unsigned i, const Four& own, const unsigned* at, Sum3& sum) {
      const Four v = spread(s.velocity + 4ul * i);
      const Four vo = gather(s.velocity, at), other = gather(s.points, at);
      const Pair p = pair(own, other, inv);
      const Lanes mean = all_lanes(2) * (own.w * other.w) / max(own.w + other.w, tiny);
      const Lanes vx = mean * (v.x - vo.x), vy = mean * (v.y - vo.y), vz = mean * (v.z - vo.z);
      Laplacian::add(p, vx, vy, vz, soft, sum.x, sum.y, sum.z);
    });
  }

  // Of differences, so that a shift has no curl at a surface either.
  static void curl(const SweepInput& s, unsigned first, unsigned last, WideReal* out4) {
    const Lanes inv = all_lanes(s.inv_support);
    sum_vectors(s, first, last, out4, [&](unsigned i, const Four& own, const unsigned* at, Sum3& sum) {
      const Four v = spread(s.velocity + 4ul * i), vo = gather(s.velocity, at);
      const Pair p = pair(own, gather(s.points, at), inv);
      const Lanes g = Gradient::slope(p.u), x = v.x - vo.x, y = v.y - vo.y, z = v.z - vo.z;
      sum.x += g * (y * p.z - z * p.y), sum.y += g * (z * p.x - x * p.z), sum.z += g * (x * p.y - y * p.x);
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

  static constexpr Sweeps table() {
    using Images = ImagesOf<Density, Gradient>;
    return {values_of<Density, One>,
            slopes,
            push_of<Gradient, OfBoth>,
            push_damped,
            push_from,
            push_near,
            growth,
            curl,
            push_of<Gradient, Difference>,
            push_of<CohesionShape, One>,
            values_of<ColorShape, One>,
            push_of<ColorShape, OfBoth>,
            viscous,
            squares_by,
            values_of<Density, OfOther>,
            push_of<CohesionShape, OfOther>,
            values_of<ColorShape, OfOther>,
            push_of<ColorShape, OfOther>,
            viscous_by,
            Images::images,
            Images::growth,
            Images::push_by};
  }
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
