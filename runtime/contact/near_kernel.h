// The arithmetic of near_batch.h. Included by near_kernel_plain.cpp and near_kernel_avx2.cpp, which differ in compiler
// flags only and give the same bits.
#pragma once
#include "contact/near_batch.h"

namespace feder {
namespace {

using namespace lanes;

unsigned near_next_closed(const RowBatch* batches, unsigned first, unsigned count, const WideReal* displacement,
                          unsigned& closed) {
  for (unsigned k = first; k < count; ++k) {
    const RowBatch& b = batches[k];
    Lanes3 d = load_points(displacement, b.v[0]) * load(b.weight[0]);
    for (int c = 1; c < 4; ++c) d = d + load_points(displacement, b.v[c]) * load(b.weight[c]);
    closed = bits_of(load(b.offset) + dot(load(b.normal), d) < zero_lanes());
    if (closed != 0) return k;
  }
  return count;
}

// Quotient; 0 where the divisor is not positive.
[[gnu::always_inline]] inline Lanes near_share(Lanes part, Lanes whole) {
  return select(whole > zero_lanes(), part / whole, zero_lanes());
}
[[gnu::always_inline]] inline Lanes near_clamp(Lanes x) {
  return select(x < zero_lanes(), zero_lanes(), select(x > all_lanes(1), all_lanes(1), x));
}

// Closest points of two segments (Ericson 2005, 5.1.9): shares of both.
[[gnu::always_inline]] inline void near_segments(const Lanes3 (&x)[4], Lanes (&weight)[4]) {
  const Lanes3 u = x[1] - x[0], v = x[3] - x[2], r = x[0] - x[2];
  const Lanes uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ur = dot(u, r), vr = dot(v, r);
  const Lanes det = uu * vv - uv * uv, one = all_lanes(1);
  Lanes s = select(det > all_lanes(1e-6f) * uu * vv, near_clamp((uv * vr - ur * vv) / det), zero_lanes());
  Lanes t = near_share(uv * s + vr, vv);
  const LaneMask low = t<zero_lanes(), high = t> one;
  s = select(low, near_clamp(near_share(-ur, uu)), select(high, near_clamp(near_share(uv - ur, uu)), s));
  t = select(low, zero_lanes(), select(high, one, t));
  weight[0] = one - s, weight[1] = s, weight[2] = t - one, weight[3] = -t;
}

// Closest point of a triangle (Ericson 2005, 5.1.5); the later cases first, the earlier ones override them.
[[gnu::always_inline]] inline void near_triangle(const Lanes3 (&x)[4], Lanes (&weight)[4]) {
  const Lanes zero = zero_lanes(), one = all_lanes(1);
  const Lanes3 ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1], bp = x[0] - x[2], cp = x[0] - x[3];
  const Lanes d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
              d6 = dot(ac, cp);
  const Lanes vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4, sum = va + vb + vc;
  Lanes w[3];
  w[1] = vb / sum, w[2] = vc / sum, w[0] = one - w[1] - w[2];
  const auto where = [&](LaneMask m, Lanes w0, Lanes w1, Lanes w2) {
    w[0] = select(m, w0, w[0]), w[1] = select(m, w1, w[1]), w[2] = select(m, w2, w[2]);
  };
  where(~(sum > zero), one, zero, zero);
  const Lanes to_b = d4 - d3, to_c = d5 - d6, side = to_b / (to_b + to_c);
  where((va <= zero) & (to_b >= zero) & (to_c >= zero) & (to_b + to_c > zero), zero, one - side, side);
  const Lanes on_ac = d2 / (d2 - d6);
  where((vb <= zero) & (d2 >= zero) & (d6 <= zero) & (d2 > d6), one - on_ac, zero, on_ac);
  where((d6 >= zero) & (d5 <= d6), zero, zero, one);
  const Lanes on_ab = d1 / (d1 - d3);
  where((vc <= zero) & (d1 >= zero) & (d3 <= zero) & (d1 > d3), one - on_ab, on_ab, zero);
  where((d3 >= zero) & (d4 <= d3), zero, one, zero);
  where((d1 <= zero) & (d2 <= zero), one, zero, zero);
  weight[0] = one, weight[1] = -w[0], weight[2] = -w[1], weight[3] = -w[2];
}

[[gnu::always_inline]] inline void near_closest(PairBatch& b, bool edges, const WideReal* at) {
  Lanes3 x[4];
  for (int k = 0; k < 4; ++k) x[k] = load_points(at, b.v[k]);
  Lanes weight[4];
  if (edges)
    near_segments(x, weight);
  else
    near_triangle(x, weight);
  const Lanes3 gap = x[0] * weight[0] + x[1] * weight[1] + x[2] * weight[2] + x[3] * weight[3];
  for (int k = 0; k < 4; ++k) store(b.weight[k], weight[k]);
  store(b.gap, gap), store(b.distance, square_root(dot(gap, gap)));
}

void near_measure(PairBatch& b, bool edges, const WideReal* at) {
  near_closest(b, edges, at);
  const Lanes3 gap = load(b.gap);
  const Lanes distance = load(b.distance);
  store(b.gap, Lanes3{gap.x / distance, gap.y / distance, gap.z / distance});
}

unsigned near_meet(PairBatch& b, bool edges, const WideReal* at, const WideReal* velocity, WideReal time) {
  near_closest(b, edges, at);
  Lanes3 u[4];
  Lanes own[4];
  for (int k = 0; k < 4; ++k) {
    u[k] = load_points(velocity, b.v[k]);
    Lane8 deviation;
    for (int i = 0; i < kLanes; ++i) deviation.v[i] = at[static_cast<unsigned long>(b.v[k][i]) * 4 + 3];
    own[k] = load(deviation);
  }
  const auto apart = [&](int i, int j) {
    const Lanes3 d = u[i] - u[j];
    return dot(d, d);
  };
  Lanes closing = max(apart(0, 2), apart(0, 3)), room = max(own[2], own[3]);
  if (edges)
    closing = max(max(apart(1, 2), apart(1, 3)), closing), room = max(own[0], own[1]) + room;
  else
    closing = max(apart(0, 1), closing), room = own[0] + max(own[1], room);
  closing = square_root(closing);
  store(b.closing, closing);
  const Lanes distance = load(b.distance), wanted = load(b.wanted);
  return bits_of((distance - wanted - room <= closing * all_lanes(time)) & (distance > wanted * all_lanes(1e-5f)));
}

constexpr NearKernels kNearKernels = {near_measure, near_meet, near_next_closed};

}  // namespace
}  // namespace feder
