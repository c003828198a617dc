// The kernels of spin_batch.h. Included by spin_plain.cpp and spin_avx2.cpp, which differ in compiler flags only and
// give the same bits. What contacts changed of the angular velocity is added to the angular momentum L through the
// inertia they were solved with. A substep then rotates the body by the angular velocity at the middle of the rotation:
// in principal axes at its start I w = exp(-[h w / 2]x) L (implicit midpoint), by fixed-point rounds. A round
// multiplies the error by about h |w| / 2, so most bodies need two or three; a lane that is done keeps its value, so
// that no body depends on its neighbours. Energy: L is kept in the world, so rounding of the pose moves it over the
// energies of the body. A free body is rotated back onto its energy by the shortest way (projection; Hairer, Lubich,
// Wanner, Geometric Numerical Integration, IV.4). The invariant is a sum without the middle axis: a body that spins
// about that axis has no digits of 2 E - |L|^2 / I in E. Weak spot: rotations of more than about 1 rad per substep
// converge slowly and stay three rounds from the midpoint.
#pragma once
#include "rigid/spin_batch.h"

namespace feder {
namespace {

using namespace lanes;

constexpr int kSpinStride = 16;  // numbers per solver body
constexpr int kSpinRounds = 3;

[[gnu::always_inline]] inline Lanes3 spin_times(const Lane8* m, const Lanes3& a) {
  const Lanes xx = load(m[0]), yy = load(m[1]), zz = load(m[2]), xy = load(m[3]), xz = load(m[4]), yz = load(m[5]);
  return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
}

// v rotated by the unit quaternion (u, w).
[[gnu::always_inline]] inline Lanes3 rotated(const Lanes3& u, Lanes w, const Lanes3& v) {
  const Lanes3 twice = cross(u, v) * all_lanes(2);
  return v + twice * w + cross(u, twice);
}

// sin x / x and (1 - cos x) / x^2 of x2 = x^2: series, whose terms left out are below rounding for x < 1/2 (float).
struct Turn {
  Lanes straight, bent;
};
[[gnu::always_inline]] inline Turn short_turn(Lanes x2) {
  const auto c = [](double x) { return all_lanes(static_cast<WideReal>(x)); };
  if constexpr (sizeof(WideReal) == 4) {
    return {c(1) - x2 * (c(1. / 6) - x2 * (c(1. / 120) - x2 * c(1. / 5040))),
            c(0.5) - x2 * (c(1. / 24) - x2 * (c(1. / 720) - x2 * c(1. / 40320)))};
  }
  return {c(1) - x2 * (c(1. / 6) - x2 * (c(1. / 120) - x2 * (c(1. / 5040) -
                                                             x2 * (c(1. / 362880) - x2 * (c(1. / 39916800) -
                                                                                          x2 * c(1. / 6227020800.)))))),
          c(0.5) - x2 * (c(1. / 24) -
                         x2 * (c(1. / 720) -
                               x2 * (c(1. / 40320) -
                                     x2 * (c(1. / 3628800) - x2 * (c(1. / 479001600) - x2 * c(1. / 87178291200.))))))};
}

// The same for any angle: whole turns taken off, an eighth of the rest by series, doubled three times.
[[gnu::noinline]] inline Turn long_turn(Lanes x2) {
  const WideReal kTurn = static_cast<WideReal>(6.283185307179586);
  const Lanes x = max(square_root(x2), all_lanes(static_cast<WideReal>(1e-3)));
  const Lanes turns = min(x * all_lanes(1 / kTurn), all_lanes(1e6f)) + all_lanes(static_cast<WideReal>(0.5));
  const Lanes rest = x - __builtin_convertvector(__builtin_convertvector(turns, LaneMask), Lanes) * all_lanes(kTurn);
  const Lanes part = rest * all_lanes(static_cast<WideReal>(0.125)), part2 = part * part;
  const Turn t = short_turn(part2);
  Lanes s = t.straight * part, versine = t.bent * part2;  // sin and 1 - cos
  for (int k = 0; k < 3; ++k) {
    const Lanes half_sine = s;
    s = all_lanes(2) * s * (all_lanes(1) - versine);
    versine = all_lanes(2) * half_sine * half_sine;
  }
  return {s / x, versine / (x * x)};
}

[[gnu::always_inline]] inline Turn turn_of(Lanes x2) {
  const Turn turn = short_turn(x2);
  const LaneMask far = x2 > all_lanes(static_cast<WideReal>(0.25));
  if (!any(far)) return turn;
  const Turn other = long_turn(x2);
  return {select(far, other.straight, turn.straight), select(far, other.bent, turn.bent)};
}

// exp(-[t]x) v, by Rodrigues' formula.
[[gnu::always_inline]] inline Lanes3 rotated_back(const Lanes3& t, const Lanes3& v) {
  const Turn turn = turn_of(dot(t, t));
  const Lanes3 along = cross(t, v);
  return v - along * turn.straight + cross(t, along) * turn.bent;
}

[[gnu::always_inline]] inline Lanes3 scaled(const Lanes3& a, const Lanes3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
[[gnu::always_inline]] inline Lanes3 negated(const Lanes3& a) { return {-a.x, -a.y, -a.z}; }

[[gnu::always_inline]] inline Lanes3 mean_angular_velocity(const SpinPass& p, const Lanes3& inv_moments,
                                                           const Lanes3& l) {
  const Lanes h = all_lanes(p.h), half = all_lanes(p.h / 2), close = all_lanes(p.close * p.close);
  Lanes3 w = scaled(inv_moments, l);
  LaneMask open = zero_lanes() == zero_lanes();
  for (int round = 0; round < kSpinRounds; ++round) {
    const Lanes3 next = scaled(inv_moments, rotated_back(w * half, l)), change = (next - w) * h;
    w = select(open, next, w);
    open = open & (dot(change, change) > close);
    if (!any(open)) break;
  }
  return w;
}

// R diag(1 / inv_moments) R^T of the unit quaternion (u, w).
[[gnu::always_inline]] inline void start_inertia(SpinBatch& b, const Lanes3& u, Lanes w) {
  const Lanes one = all_lanes(1), zero = zero_lanes();
  const Lanes3 inv = load(b.inv_moments);
  const Lanes3 x = rotated(u, w, Lanes3{one, zero, zero}), y = rotated(u, w, Lanes3{zero, one, zero}),
               z = rotated(u, w, Lanes3{zero, zero, one});
  const Lanes3 mx = x * (one / inv.x), my = y * (one / inv.y), mz = z * (one / inv.z);
  store(b.inertia[0], mx.x * x.x + my.x * y.x + mz.x * z.x);
  store(b.inertia[1], mx.y * x.y + my.y * y.y + mz.y * z.y);
  store(b.inertia[2], mx.z * x.z + my.z * y.z + mz.z * z.z);
  store(b.inertia[3], mx.x * x.y + my.x * y.y + mz.x * z.y);
  store(b.inertia[4], mx.x * x.z + my.x * y.z + mz.x * z.z);
  store(b.inertia[5], mx.y * x.z + my.y * y.z + mz.y * z.z);
}

// Angular momentum `l` in principal axes onto the energy of the body; returns the rotation of the body that does it.
[[gnu::always_inline]] inline Lanes3 project(SpinBatch& b, LaneMask free, Lanes3& l) {
  const Lanes zero = zero_lanes(), one = all_lanes(1);
  const Lanes3 slope = scaled(load(b.saddle), l);
  const Lanes known = load(b.invariant), now = dot(slope, l), l2 = dot(l, l);
  free = free & (known < all_lanes(kUnknownSpin)) & (l2 > all_lanes(1e-30f));
  const Lanes inv_l2 = select(free, one / select(free, l2, one), zero);
  const Lanes3 along = slope - l * (now * inv_l2);
  const Lanes steep = dot(along, along);
  free = free & (steep > all_lanes(1e-30f));
  const Lanes s = select(free, (known - now) / (select(free, steep, one) * all_lanes(2)), zero);
  // more than a hundredth of a radian is no rounding
  free = free & (s * s * steep * inv_l2 < all_lanes(static_cast<WideReal>(1e-4)));
  const Lanes part = select(free, s, zero);
  const Lanes3 turn = cross(along, l) * (part * inv_l2);
  l = l + along * part;
  store(b.invariant, select(free, known, now));
  return turn;
}

void spin_batches(const SpinPass& p) {
  for (unsigned n = p.first; n < p.last; ++n) {
    SpinBatch& b = p.batches[n];
    Lanes motion[kLanes], pose[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      motion[i] = load_row(p.bodies + b.index[i] * kSpinStride);
      pose[i] = load_row(p.bodies + b.index[i] * kSpinStride + kLanes);
    }
    transpose(motion), transpose(pose);
    // principal axes in the world
    const Lanes3 q{pose[4], pose[5], pose[6]}, r = load(b.axis);
    const Lanes3 axis = r * pose[7] + q * load(b.real) + cross(q, r);
    const Lanes real = pose[7] * load(b.real) - dot(q, r);
    if (p.start) start_inertia(b, axis, real);
    // momentum with pushes and torque, damped implicitly
    const Lanes one = all_lanes(1), h = all_lanes(p.h), damping = load(b.damping);
    const Lanes3 pushed = Lanes3{motion[3], motion[4], motion[5]} - load(b.given), torque = load(b.torque);
    const Lanes3 l = (load(b.momentum) + spin_times(b.inertia, pushed) + torque * h) * (one / (one + h * damping));
    store(b.momentum, l);
    // rotation
    const LaneMask free = dot(pushed, pushed) + dot(torque, torque) + damping * damping == zero_lanes();
    Lanes3 own = rotated(negated(axis), real, l);
    const Lanes3 turn = project(b, free, own);
    const Lanes3 w = rotated(axis, real, mean_angular_velocity(p, load(b.inv_moments), own) + turn * (one / h));
    store(b.given, w);
    motion[3] = w.x, motion[4] = w.y, motion[5] = w.z;
    transpose(motion);
    for (unsigned i = 0; i < b.count; ++i) store_row(p.bodies + b.index[i] * kSpinStride, motion[i]);
  }
}

bool push_bodies(const PushPass& p) {
  const Lanes h = all_lanes(p.h);
  LaneMask finite = zero_lanes() == zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    WideReal* body = p.bodies + i * kSpinStride;
    const Lanes row = (load_row(body) + h * load(p.pushes[i].change)) * load(p.pushes[i].keep);
    store_row(body, row);
    finite &= row - row == zero_lanes();
  }
  return !any(~finite);
}

// Eight at a time; what does not rotate keeps its quaternion to the bit.
void drift_bodies(const DriftPass& p) {
  const Lanes h = all_lanes(p.h), half = all_lanes(static_cast<WideReal>(0.5)), zero = zero_lanes();
  for (unsigned at = p.first; at < p.last; at += kLanes) {
    const unsigned count = p.last - at < kLanes ? p.last - at : kLanes;
    WideReal* rows[kLanes];
    Lanes motion[kLanes], pose[kLanes];
    for (unsigned i = 0; i < kLanes; ++i) {
      rows[i] = p.bodies + (at + (i < count ? i : 0)) * kSpinStride;
      motion[i] = load_row(rows[i]);
      pose[i] = load_row(rows[i] + kLanes);
    }
    transpose(motion), transpose(pose);
    motion[6] += h * motion[0], motion[7] += h * motion[1], pose[0] += h * motion[2];
    const Lanes3 turn = Lanes3{motion[3], motion[4], motion[5]} * h;
    pose[1] += turn.x, pose[2] += turn.y, pose[3] += turn.z;
    // exp(turn / 2) q
    const LaneMask still = (turn.x == zero) & (turn.y == zero) & (turn.z == zero);
    const Lanes3 t = turn * half, q{pose[4], pose[5], pose[6]};
    const Lanes x2 = dot(t, t);
    const Turn sine = turn_of(x2);
    const Lanes3 u = t * sine.straight;
    const Lanes c = all_lanes(1) - sine.bent * x2, real = pose[7];
    Lanes3 next = u * real + q * c + cross(u, q);
    Lanes next_real = c * real - dot(u, q);
    // its length is 1 but for rounding
    const Lanes scale = all_lanes(static_cast<WideReal>(1.5)) - half * (dot(next, next) + next_real * next_real);
    next = select(still, q, next * scale), next_real = select(still, real, next_real * scale);
    pose[4] = next.x, pose[5] = next.y, pose[6] = next.z, pose[7] = next_real;
    transpose(motion), transpose(pose);
    for (unsigned i = 0; i < count; ++i) {
      store_row(rows[i], motion[i]);
      store_row(rows[i] + kLanes, pose[i]);
    }
  }
}

}  // namespace
}  // namespace feder
