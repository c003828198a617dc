// Spring kernels, eight points at a time. Included by spring_plain.cpp and spring_avx2.cpp, which differ in
// compiler flags only and give the same bits.
//
// With d = x_other - x, len = |d|, u = v_other - v a spring pulls its point with
//   f = d (tension / len),  tension = stiffness (len - rest_length) + damping (u.d) / len.
// With a power p the first part is stiffness |e|^(p-1) e, e = len - rest_length, by products.
// Every operation is symmetric under d -> -d, u -> -u: both ends get the same number with opposite signs, and momentum
// is exact to rounding. A spring without length pulls along x, from the lower point number to the higher.
// One division and one square root per spring end, no estimates of either (rsqrt differs between processors).
#pragma once
#include "feder/error.h"
#include "springs/spring_batch.h"

namespace feder {
namespace {

using namespace lanes;

// Directions of springs without length: rare, so kept out of the registers of the loop. Returns their number.
[[gnu::noinline]] unsigned give_direction(const SpringRow& row, unsigned self, const Lane8& square, Lane8x3& d,
                                          Lane8& length) {
  unsigned found = 0;
  for (int i = 0; i < kLanes; ++i) {
    if (!(square.v[i] <= kNoLength2)) continue;
    d.x.v[i] = row.other[i] > self + static_cast<unsigned>(i) ? 1 : -1;
    d.y.v[i] = d.z.v[i] = 0;
    length.v[i] = 0;
    if (row.stiffness.v[i] > 0 && row.rest_length.v[i] > 0) ++found;
  }
  return found;
}

template <bool kDamped, bool kSlack, bool kPower>
[[gnu::always_inline]] inline unsigned add_slice(const SpringPass& p, unsigned slice) {
  const Lanes zero = zero_lanes(), one = all_lanes(1);
  unsigned own[kLanes], found = 0;
  for (unsigned i = 0; i < kLanes; ++i) own[i] = slice * kLanes + i;
  const Lanes3 x = load_points(p.position, own);
  Lanes3 v{};
  if constexpr (kDamped) v = load_points(p.velocity, own);
  FEDER_ASSERT(p.row_begin[slice] <= p.row_begin[slice + 1] && kPower == (p.power != nullptr));
  Lanes3 sum = load(p.force[slice]);
  for (unsigned r = p.row_begin[slice]; r < p.row_begin[slice + 1]; ++r) {
    const SpringRow& row = p.rows[r];
    Lanes3 d = load_points(p.position, row.other) - x;
    const Lanes square = dot(d, d);
    Lanes length = square_root(square), divisor = length;
    const LaneMask none = square <= all_lanes(kNoLength2);
    if (any(none)) [[unlikely]] {
      Lane8x3 direction;
      Lane8 square_now, length_now;
      store(direction, d), store(square_now, square), store(length_now, length);
      found += give_direction(row, slice * kLanes, square_now, direction, length_now);
      d = load(direction), length = load(length_now);
      divisor = select(none, one, length);
    }
    const Lanes inverse = one / divisor;
    const Lanes stretch = length - load(row.rest_length);
    Lanes tension = load(row.stiffness) * stretch;
    if constexpr (kPower) {
      const Lanes size = max(stretch, zero - stretch), power = load(p.power[r]);
      Lanes done = one;
      for (LaneMask more = power > done; any(more); more = power > done) {
        tension = select(more, tension * size, tension);
        done += one;
      }
    }
    if constexpr (kDamped) {
      const Lanes3 u = load_points(p.velocity, row.other) - v;
      tension += load(p.damping[r]) * (dot(u, d) * inverse);
    }
    if constexpr (kSlack) {
      // slack below the rest length, and never pushing; a NaN stays one
      const LaneMask limp = (load(p.slack[r]) > zero) & ((stretch <= zero) | (tension < zero));
      tension = select(limp, zero, tension);
    }
    sum = sum + d * (tension * inverse);
  }
  store(p.force[slice], sum);
  return found;
}

template <bool kDamped, bool kSlack, bool kPower>
unsigned add_slices(const SpringPass& p) {
  unsigned found = 0;
  for (unsigned s = p.first; s < p.last; ++s) found += add_slice<kDamped, kSlack, kPower>(p, s);
  return found;
}

template <bool kPower>
unsigned add_forces_of(const SpringPass& p) {
  if (p.damping) return p.slack ? add_slices<true, true, kPower>(p) : add_slices<true, false, kPower>(p);
  return p.slack ? add_slices<false, true, kPower>(p) : add_slices<false, false, kPower>(p);
}

unsigned add_forces(const SpringPass& p) { return p.power ? add_forces_of<true>(p) : add_forces_of<false>(p); }

unsigned find_snapped(const SnapPass& p) {
  FEDER_ASSERT(p.first == p.last || (p.last - 1) * kLanes < p.count);
  unsigned found = 0;
  for (unsigned g = p.first; g < p.last; ++g) {
    unsigned i[kLanes], j[kLanes];
    Lane8 limit;
    for (unsigned k = 0; k < kLanes; ++k) {
      const unsigned at = g * kLanes + k < p.count ? g * kLanes + k : p.count - 1;
      i[k] = p.i[at], j[k] = p.j[at], limit.v[k] = p.limit[at];
    }
    const Lanes3 d = load_points(p.position, j) - load_points(p.position, i);
    const LaneMask over = dot(d, d) > load(limit);
    unsigned bits = 0;
    if (any(over)) [[unlikely]]
      for (unsigned k = 0; k < kLanes; ++k)
        if (over[k] && g * kLanes + k < p.count) bits |= 1u << k, ++found;
    p.snapped[g] = static_cast<unsigned char>(bits);
  }
  return found;
}

constexpr SpringKernels kKernels = {add_forces, find_snapped};

}  // namespace
}  // namespace feder
