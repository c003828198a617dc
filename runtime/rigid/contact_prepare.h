// Part of the contact kernels (contact_kernel.h): batches from contacts, and again when their bodies have turned.
#pragma once
#include "rigid/contact_kernel.h"

namespace feder {
namespace {

[[gnu::always_inline]] inline void prepare_masses(const ContactPass& p, ContactBatch& c, BatchExtra& extra) {
  Lanes3 axes[2];
  LaneMask locked{};
  for (int k = 0; k < 2; ++k) {
    const unsigned* index = k ? c.index_b : c.index_a;
    Lanes r[kLanes];
    for (int i = 0; i < kLanes; ++i) r[i] = load_row(reinterpret_cast<const WideReal*>(p.masses + index[i]));
    transpose(r);
    const Lanes inv_mass = max(max(r[0], r[1]), r[2]);
    store(k ? c.inv_mass_b : c.inv_mass_a, inv_mass);
    axes[k] = {r[0], r[1], r[2]};
    locked |= (r[0] < inv_mass) | (r[1] < inv_mass) | (r[2] < inv_mass);
    Lane8* inertia = k ? c.inv_inertia_b : c.inv_inertia_a;
    for (int n = 0; n < 5; ++n) store(inertia[n], r[n + 3]);
    for (int i = 0; i < kLanes; ++i) inertia[5].v[i] = p.masses[index[i]].inv_inertia[5];
  }
  c.locked = any(locked);
  if (c.locked) store(extra.axes_a, axes[0]), store(extra.axes_b, axes[1]);
}

// Effective masses and couplings of the points; kFirst: their masses are 1 or 0, and the compliance is not known.
template <bool kFirst>
[[gnu::always_inline]] inline void prepare_normals(const ContactPass& p, const Frame& f, ContactBatch& c,
                                                   const BatchExtra& extra) {
  const Lanes one = all_lanes(1), zero = zero_lanes();
  const Lanes along = dot(parting_of(c, extra, f.n), f.n);
  const Lanes3 center_a = cross(load(c.center_a), f.n), center_b = cross(load(c.center_b), f.n);
  Lanes3 a[kBatchPoints], b[kBatchPoints];
  Lanes sum = zero;
  for (int j = 0; j < kBatchPoints; ++j) {
    BatchPoint& q = c.point[j];
    const Lanes valid = select(load(q.mass) > zero, one, zero);
    const Lanes3 off = f.t1 * load(q.y) - f.t2 * load(q.x);
    a[j] = center_a + off, b[j] = center_b + off;
    const Lanes3 ia = times(c.inv_inertia_a, a[j]), ib = times(c.inv_inertia_b, b[j]);
    for (int k = 0; k < j; ++k) store(c.coupling[kPair[j][k]], along + dot(a[k], ia) + dot(b[k], ib));
    const Lanes mass = reciprocal_or_zero(along + dot(a[j], ia) + dot(b[j], ib)) * valid;
    store(q.mass, mass);
    sum += mass;
  }
  if constexpr (!kFirst) return;
  // compliance: together the points are as stiff as a single one between the same two bodies (a face that cannot rotate
  // would be four times as stiff). They are softer against tilting: corners act there with a lever and with little
  // inertia, and one pass over a stack of five would not converge. So the compliance is a matrix: leak / mass on the
  // diagonal, minus leak_mean on all entries
  const LaneMask fixed = mask_of(c.fixed);
  const Lanes leak = all_lanes(kTilt * p.soft.impulse_scale) * load(c.leak) * max(one, sum * along);
  const Lanes own = select(fixed, all_lanes(p.soft_fixed.impulse_scale), min(leak, one));
  store(c.leak, own);
  store(c.leak_mean, select(fixed, zero, own * all_lanes(1 - 1 / kTilt)) * reciprocal_or_zero(sum));
}

// The centre of the manifold from the arms, and where the points lie around it: by the arms of the body that is nearer,
// which are the more exact ones.
[[gnu::always_inline]] inline void prepare_center(const BatchInput& in, const Frame& f, ContactBatch& c) {
  Lanes count = zero_lanes();
  Lanes3 a{}, b{};
  for (int j = 0; j < kBatchPoints; ++j) {
    const Lanes valid = load(c.point[j].mass);
    count += valid;
    a = a + load(in.arm_a[j]) * valid;
    b = b + load(in.arm_b[j]) * valid;
  }
  const Lanes weight = all_lanes(1) / max(count, all_lanes(1));
  a = a * weight, b = b * weight;
  store(c.center_a, a);
  store(c.center_b, b);
  const LaneMask by_a = dot(a, a) <= dot(b, b);
  for (int j = 0; j < kBatchPoints; ++j) {
    const Lanes3 d = select(by_a, load(in.arm_a[j]) - a, load(in.arm_b[j]) - b);
    store(c.point[j].x, dot(d, f.t1) * load(c.point[j].mass));
    store(c.point[j].y, dot(d, f.t2) * load(c.point[j].mass));
  }
}

[[gnu::always_inline]] inline void prepare_friction(const Frame& f, ContactBatch& c, const BatchExtra& extra) {
  const Lanes3 &n = f.n, &t1 = f.t1, &t2 = f.t2;
  const Lanes3 m1 = parting_of(c, extra, t1), m2 = parting_of(c, extra, t2);
  const Lanes3 a1 = cross(load(c.center_a), t1), a2 = cross(load(c.center_a), t2);
  const Lanes3 b1 = cross(load(c.center_b), t1), b2 = cross(load(c.center_b), t2);
  const Lanes3 ia1 = times(c.inv_inertia_a, a1), ib1 = times(c.inv_inertia_b, b1);
  const Lanes k11 = dot(m1, t1) + dot(a1, ia1) + dot(b1, ib1);
  const Lanes k12 = dot(m1, t2) + dot(a2, ia1) + dot(b2, ib1);
  const Lanes k22 = dot(m2, t2) + dot(a2, times(c.inv_inertia_a, a2)) + dot(b2, times(c.inv_inertia_b, b2));
  // singular (planar worlds, locked axes): the pseudo-inverse of a matrix of rank one, so that a direction in which
  // nothing but rounding can move gets no impulse
  const Lanes det = k11 * k22 - k12 * k12, trace2 = (k11 + k22) * (k11 + k22);
  const LaneMask good = det > all_lanes(WideReal(1e-6)) * trace2;
  const Lanes inv = select(good, all_lanes(1) / select(good, det, all_lanes(1)), zero_lanes());
  const Lanes flat = reciprocal_or_zero(trace2);
  store(c.tangent_mass[0], select(good, k22 * inv, k11 * flat));
  store(c.tangent_mass[1], select(good, -k12 * inv, k12 * flat));
  store(c.tangent_mass[2], select(good, k11 * inv, k22 * flat));
  store(c.twist_mass, reciprocal_or_zero(dot(n, times(c.inv_inertia_a, n)) + dot(n, times(c.inv_inertia_b, n))));
}

// Inverse of a symmetric matrix by cofactors; zero when singular.
[[gnu::always_inline]] inline void prepare_rolling(const ContactBatch& c, BatchExtra& extra) {
  Lanes m[6];
  for (int k = 0; k < 6; ++k) m[k] = load(c.inv_inertia_a[k]) + load(c.inv_inertia_b[k]);
  // an axis without rotation (planar worlds) gets no impulse; in units of the trace: determinants of large bodies
  // underflow
  const Lanes trace = m[0] + m[1] + m[2], per_trace = reciprocal_or_zero(trace);
  for (int k = 0; k < 6; ++k) m[k] = m[k] * per_trace;
  for (int k = 0; k < 3; ++k) m[k] = select(m[k] > zero_lanes(), m[k], all_lanes(1));
  const Lanes cxx = m[1] * m[2] - m[5] * m[5], cxy = m[4] * m[5] - m[3] * m[2], cxz = m[3] * m[5] - m[4] * m[1];
  const Lanes det = m[0] * cxx + m[3] * cxy + m[4] * cxz;
  const Lanes inv = reciprocal_or_zero(det) * per_trace;
  store(extra.rolling_mass[0], cxx * inv);
  store(extra.rolling_mass[1], (m[0] * m[2] - m[4] * m[4]) * inv);
  store(extra.rolling_mass[2], (m[0] * m[1] - m[3] * m[3]) * inv);
  store(extra.rolling_mass[3], cxy * inv);
  store(extra.rolling_mass[4], cxz * inv);
  store(extra.rolling_mass[5], (m[3] * m[4] - m[0] * m[5]) * inv);
}

void prepare_batches(const ContactPass& p) {
  FEDER_ASSERT(p.first + 1 == p.last && p.input);
  ContactBatch& c = p.batches[p.first];
  BatchExtra& extra = p.extras[p.first];
  FEDER_ASSERT(c.points >= 1 && c.points <= kBatchPoints);
  // the world is never written
  for (int k = 0; k < kLanes; ++k) FEDER_ASSERT(c.index_a[k] > 0 || !(c.writes_a >> k & 1u));
  for (int k = 0; k < kLanes; ++k) FEDER_ASSERT(c.index_b[k] > 0 || !(c.writes_b >> k & 1u));
  const Frame f = frame_of(c);
  prepare_center(*p.input, f, c);
  prepare_masses(p, c, extra);
  prepare_normals<true>(p, f, c, extra);
  prepare_friction(f, c, extra);
  if (c.rolls) prepare_rolling(c, extra);
  Sides s;
  gather_velocity(p, c, s);
  const Closing speeds = speeds_of(f, c, s);
  Lanes warm = zero_lanes(), closing = load(p.input->lands);
  for (int j = 0; j < kBatchPoints; ++j) {
    warm += load(c.point[j].impulse);
    closing = max(closing, -point_closing(c.point[j], speeds));
  }
  c.warm = static_cast<unsigned char>(bits_of(warm > zero_lanes()));
  const LaneMask landing = ~(warm > zero_lanes()) & (closing > all_lanes(kColdSpeed));
  c.rounds = static_cast<unsigned char>(any(landing) ? kColdRounds : 1);
}

void renew_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    ContactBatch& c = p.batches[i];
    BatchExtra& extra = p.extras[i];
    const Frame f = frame_of(c);
    prepare_masses(p, c, extra);
    prepare_normals<false>(p, f, c, extra);
    prepare_friction(f, c, extra);
    if (c.rolls) prepare_rolling(c, extra);
  }
}

}  // namespace
}  // namespace feder
