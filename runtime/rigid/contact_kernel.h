// Contact kernels of the soft step, eight contacts at a time. Included by contact_plain.cpp and contact_avx2.cpp, which
// differ in compiler flags only and give the same bits.
//
// Rows are linear in the step: the normal and arm x normal stay as they were at its start, so the speed and the
// separation of a point use the same numbers (v, w) and (delta_position, delta_rotation). Within a manifold the points
// are solved by symmetric Gauss-Seidel in impulse space: their coupling is known, so the bodies are read and written
// once per pass. Soft rows: Catto, "Soft Constraints", GDC 2011, and "Solver2D", 2024. Friction is a cone at
// the manifold's centre with static and dynamic limit, plus twist about the normal (limit: sum of normal impulse x
// distance).
#pragma once
#include "feder/error.h"
#include "rigid/contact_batch.h"

namespace feder {
namespace {

using namespace lanes;

constexpr int kStride = 16;               // numbers per solver body
constexpr unsigned kColdRounds = 4;       // a flat landing converges within 1e-3 of its solution without rotation
constexpr unsigned kLoadRounds = 16;      // a cube loaded at once: each leaves 0.6 of the error
constexpr WideReal kLoadPart = 0.02f;     // of the static limit: smaller changes of friction count as converged
constexpr WideReal kLightPart = 0.2f;     // of the static limit: less friction is not worth rounds (a rod needs 1/4)
constexpr WideReal kSlip = 2;             // times the static limit: an impulse that would stop a sliding manifold
constexpr WideReal kColdSpeed = 0.001f;   // m/s; a contact without warm start that closes faster is landing
constexpr WideReal kOver = 1.3f;          // over-relaxation (Young 1954) of what rests: towers of 60 lean without it
constexpr WideReal kBiasFriction = 0.8f;  // part of friction that the pass with bias solves; see solve_batches
constexpr WideReal kFar = 1e6f;           // m; a separation at which a point does nothing
constexpr WideReal kTilt = 1.75f;         // compliance against tilting over that against pushing; see prepare_normals

// Symmetric matrix times vector.
[[gnu::always_inline]] inline Lanes3 times(const Lane8* m, const Lanes3& a) {
  const Lanes xx = load(m[0]), yy = load(m[1]), zz = load(m[2]), xy = load(m[3]), xz = load(m[4]), yz = load(m[5]);
  return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
}
[[gnu::always_inline]] inline Lanes3 times(const Lanes3& diagonal, const Lanes3& a) {
  return {diagonal.x * a.x, diagonal.y * a.y, diagonal.z * a.z};
}

// One half of eight solver bodies: row 0 holds v, w and the first two of delta_position; row 1 the third,
// delta_rotation and rotation.
[[gnu::always_inline]] inline void gather(const WideReal* bodies, const unsigned* index, int row,
                                          Lanes (&out)[kLanes]) {
  for (int i = 0; i < kLanes; ++i) out[i] = load_row(bodies + index[i] * kStride + row * kLanes);
  transpose(out);
}

[[gnu::always_inline]] inline void scatter(WideReal* bodies, const unsigned* index, unsigned writes,
                                           Lanes (&rows)[kLanes]) {
  transpose(rows);
  for (int i = 0; i < kLanes; ++i)
    if (writes >> i & 1u) store_row(bodies + index[i] * kStride, rows[i]);
}

// Both sides of a batch: velocities now, and the rows they came in (to be written back).
struct Sides {
  Lanes a[kLanes], b[kLanes];
  Lanes3 delta_position, delta_rotation_a, delta_rotation_b;  // b minus a
};

[[gnu::always_inline]] inline void gather_velocity(const ContactPass& p, const ContactBatch& c, Sides& s) {
  gather(p.bodies, c.index_a, 0, s.a);
  gather(p.bodies, c.index_b, 0, s.b);
}

[[gnu::always_inline]] inline void gather_displacement(const ContactPass& p, const ContactBatch& c, Sides& s) {
  Lanes a[kLanes], b[kLanes];
  gather(p.bodies, c.index_a, 1, a);
  gather(p.bodies, c.index_b, 1, b);
  s.delta_position = {s.b[6] - s.a[6], s.b[7] - s.a[7], b[0] - a[0]};
  s.delta_rotation_a = {a[1], a[2], a[3]};
  s.delta_rotation_b = {b[1], b[2], b[3]};
}

[[gnu::always_inline]] inline void put(Lanes (&rows)[kLanes], const Lanes3& v, const Lanes3& w) {
  rows[0] = v.x, rows[1] = v.y, rows[2] = v.z, rows[3] = w.x, rows[4] = w.y, rows[5] = w.z;
}
[[gnu::always_inline]] inline Lanes3 linear(const Lanes (&rows)[kLanes]) { return {rows[0], rows[1], rows[2]}; }
[[gnu::always_inline]] inline Lanes3 angular(const Lanes (&rows)[kLanes]) { return {rows[3], rows[4], rows[5]}; }

// Velocities changed by the linear impulse `l` and the angular impulses (on b; the opposite signs on a).
[[gnu::always_inline]] inline void push(const ContactBatch& c, Sides& s, const Lanes3& l, const Lanes3& angular_a,
                                        const Lanes3& angular_b) {
  put(s.a, linear(s.a) - times(load(c.inv_mass_a), l), angular(s.a) - times(c.inv_inertia_a, angular_a));
  put(s.b, linear(s.b) + times(load(c.inv_mass_b), l), angular(s.b) + times(c.inv_inertia_b, angular_b));
}

[[gnu::always_inline]] inline void write_back(const ContactPass& p, const ContactBatch& c, Sides& s) {
  scatter(p.bodies, c.index_a, c.writes_a, s.a);
  scatter(p.bodies, c.index_b, c.writes_b, s.b);
}

[[gnu::always_inline]] inline Lanes reciprocal_or_zero(Lanes k) {
  const LaneMask good = k > zero_lanes();
  return select(good, all_lanes(1) / select(good, k, all_lanes(1)), zero_lanes());
}

constexpr int kPair[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

[[gnu::always_inline]] inline Lanes point_speed(const BatchPoint& q, Lanes along, const Lanes3& wa, const Lanes3& wb) {
  return along + dot(load(q.angular_b), wb) - dot(load(q.angular_a), wa);
}

[[gnu::always_inline]] inline void prepare_masses(const ContactPass& p, ContactBatch& c) {
  for (int side = 0; side < 2; ++side) {
    const unsigned* index = side ? c.index_b : c.index_a;
    Lanes r[kLanes];
    for (int i = 0; i < kLanes; ++i) r[i] = load_row(reinterpret_cast<const WideReal*>(p.masses + index[i]));
    transpose(r);
    store(side ? c.inv_mass_b : c.inv_mass_a, Lanes3{r[0], r[1], r[2]});
    Lane8* inertia = side ? c.inv_inertia_b : c.inv_inertia_a;
    for (int k = 0; k < 5; ++k) store(inertia[k], r[k + 3]);
    for (int i = 0; i < kLanes; ++i) inertia[5].v[i] = p.masses[index[i]].inv_inertia[5];
  }
}

// Effective masses and couplings of the points; kFirst: their arms are not yet multiplied by the normal.
template <bool kFirst>
[[gnu::always_inline]] inline void prepare_normals(const ContactPass& p, ContactBatch& c) {
  const Lanes3 n = load(c.normal);
  const Lanes3 inv_mass = load(c.inv_mass_a) + load(c.inv_mass_b);
  const Lanes along = dot(times(inv_mass, n), n);
  Lanes sum = zero_lanes();
  for (int j = 0; j < kBatchPoints; ++j) {
    BatchPoint& q = c.point[j];
    Lanes valid = load(q.mass);
    Lanes3 a = load(q.angular_a), b = load(q.angular_b);
    if constexpr (kFirst) {
      a = cross(a, n) * valid, b = cross(b, n) * valid;
      store(q.angular_a, a);
      store(q.angular_b, b);
    } else {
      valid = select(valid > zero_lanes(), all_lanes(1), zero_lanes());
    }
    const Lanes3 ia = times(c.inv_inertia_a, a), ib = times(c.inv_inertia_b, b);
    for (int k = 0; k < j; ++k)
      store(c.coupling[kPair[j][k]], along + dot(load(c.point[k].angular_a), ia) + dot(load(c.point[k].angular_b), ib));
    const Lanes mass = reciprocal_or_zero(along + dot(a, ia) + dot(b, ib)) * valid;
    store(q.mass, mass);
    sum += mass;
  }
  if constexpr (!kFirst) return;
  // compliance: together the points are as stiff as a single one between the same two bodies (a face that cannot rotate
  // would be four times as stiff). They are softer against tilting: corners act there with a lever and with little
  // inertia, and one pass over a stack of five would not converge. So the compliance is a matrix: leak / mass on the
  // diagonal, minus leak_mean on all entries
  const Lanes one = all_lanes(1), zero = zero_lanes();
  const LaneMask fixed = load(c.against_fixed) > zero;
  const Lanes leak = all_lanes(kTilt * p.soft.impulse_scale) * load(c.leak) * max(one, sum * along);
  const Lanes own = select(fixed, all_lanes(p.soft_fixed.impulse_scale), min(leak, one));
  store(c.leak, own);
  store(c.leak_mean, select(fixed, zero, own * all_lanes(1 - 1 / kTilt)) * reciprocal_or_zero(sum));
}

// The centre of the manifold from the arms (before they are overwritten), and the distances from it.
[[gnu::always_inline]] inline void prepare_center(ContactBatch& c) {
  Lanes count = zero_lanes();
  Lanes3 a{}, b{};
  for (int j = 0; j < kBatchPoints; ++j) {
    const Lanes valid = load(c.point[j].mass);
    count += valid;
    a = a + load(c.point[j].angular_a) * valid;
    b = b + load(c.point[j].angular_b) * valid;
  }
  const Lanes weight = all_lanes(1) / max(count, all_lanes(1));
  a = a * weight, b = b * weight;
  store(c.center_a, a);
  store(c.center_b, b);
  for (int j = 0; j < kBatchPoints; ++j) {
    const Lanes3 d = load(c.point[j].angular_a) - a;
    store(c.radius[j], square_root(dot(d, d)) * load(c.point[j].mass));
  }
}

[[gnu::always_inline]] inline void prepare_friction(ContactBatch& c) {
  const Lanes3 n = load(c.normal);
  // tangent_frame(n) of feder/types.h (Duff et al. 2017)
  const Lanes one = all_lanes(1);
  const Lanes sign = select(n.z < zero_lanes(), -one, one);
  const Lanes s = -one / (sign + n.z);
  const Lanes3 t1{one + sign * n.x * n.x * s, sign * n.x * n.y * s, -sign * n.x};
  const Lanes3 t2 = cross(n, t1);
  store(c.tangent, t1);
  const Lanes3 inv_mass = load(c.inv_mass_a) + load(c.inv_mass_b);
  const Lanes3 a1 = cross(load(c.center_a), t1), a2 = cross(load(c.center_a), t2);
  const Lanes3 b1 = cross(load(c.center_b), t1), b2 = cross(load(c.center_b), t2);
  const Lanes3 ia1 = times(c.inv_inertia_a, a1), ib1 = times(c.inv_inertia_b, b1);
  const Lanes k11 = dot(times(inv_mass, t1), t1) + dot(a1, ia1) + dot(b1, ib1);
  const Lanes k12 = dot(times(inv_mass, t1), t2) + dot(a2, ia1) + dot(b2, ib1);
  const Lanes k22 =
      dot(times(inv_mass, t2), t2) + dot(a2, times(c.inv_inertia_a, a2)) + dot(b2, times(c.inv_inertia_b, b2));
  // singular (planar worlds, locked axes): the pseudo-inverse of a matrix of rank one, so that a direction in which
  // nothing but rounding can move gets no impulse
  const Lanes det = k11 * k22 - k12 * k12, trace2 = (k11 + k22) * (k11 + k22);
  const LaneMask good = det > all_lanes(WideReal(1e-6)) * trace2;
  const Lanes inv = select(good, one / select(good, det, one), zero_lanes());
  const Lanes flat = reciprocal_or_zero(trace2);
  store(c.tangent_mass[0], select(good, k22 * inv, k11 * flat));
  store(c.tangent_mass[1], select(good, -k12 * inv, k12 * flat));
  store(c.tangent_mass[2], select(good, k11 * inv, k22 * flat));
  store(c.twist_mass, reciprocal_or_zero(dot(n, times(c.inv_inertia_a, n)) + dot(n, times(c.inv_inertia_b, n))));
}

// Inverse of a symmetric matrix by cofactors; zero when singular.
[[gnu::always_inline]] inline void prepare_rolling(const ContactBatch& c, BatchSide& side) {
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
  store(side.rolling_mass[0], cxx * inv);
  store(side.rolling_mass[1], (m[0] * m[2] - m[4] * m[4]) * inv);
  store(side.rolling_mass[2], (m[0] * m[1] - m[3] * m[3]) * inv);
  store(side.rolling_mass[3], cxy * inv);
  store(side.rolling_mass[4], cxz * inv);
  store(side.rolling_mass[5], (m[3] * m[4] - m[0] * m[5]) * inv);
}

void prepare_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    ContactBatch& c = p.batches[i];
    BatchSide& side = p.sides[i];
    FEDER_ASSERT(c.points >= 1 && c.points <= kBatchPoints);
    // the world is never written
    for (int k = 0; k < kLanes; ++k) FEDER_ASSERT(c.index_a[k] > 0 || !(c.writes_a >> k & 1u));
    for (int k = 0; k < kLanes; ++k) FEDER_ASSERT(c.index_b[k] > 0 || !(c.writes_b >> k & 1u));
    prepare_center(c);
    prepare_masses(p, c);
    prepare_normals<true>(p, c);
    prepare_friction(c);
    if (side.rolls) prepare_rolling(c, side);
    Sides s;
    gather_velocity(p, c, s);
    const Lanes along = dot(load(c.normal), linear(s.b) - linear(s.a));
    Lanes warm = zero_lanes(), closing = load(side.lands);
    for (int j = 0; j < kBatchPoints; ++j) {
      const Lanes approach = point_speed(c.point[j], along, angular(s.a), angular(s.b));
      store(side.approach[j], approach);
      store(side.total[j], zero_lanes());
      warm += load(c.point[j].impulse);
      closing = max(closing, -approach);
    }
    // over-relaxation for resting stacks, where one relax pass has to remove the bias; not for impacts
    store(c.over,
          select((load(c.against_fixed) > zero_lanes()) | ~(warm > zero_lanes()), all_lanes(1), all_lanes(kOver)));
    Lane8 landing;
    store(landing, select(warm > zero_lanes(), zero_lanes(), closing));
    c.rounds = 1;
    for (int k = 0; k < kLanes; ++k)
      if (landing.v[k] > kColdSpeed) c.rounds = kColdRounds;
  }
}

void renew_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    ContactBatch& c = p.batches[i];
    prepare_masses(p, c);
    prepare_normals<false>(p, c);
    prepare_friction(c);
    if (p.sides[i].rolls) prepare_rolling(c, p.sides[i]);
  }
}

// Velocity change by the impulses of a batch, times `scale` by lane.
[[gnu::always_inline]] inline void push_impulses(const ContactBatch& c, const BatchSide& side, Lanes scale, Sides& s) {
  const Lanes3 n = load(c.normal), t1 = load(c.tangent), t2 = cross(n, t1);
  Lanes sum = zero_lanes();
  Lanes3 angular_a = n * load(c.twist_impulse), angular_b = angular_a;
  if (side.rolls) angular_a = angular_a + load(side.rolling_impulse), angular_b = angular_a;
  for (unsigned j = 0; j < c.points; ++j) {
    const Lanes impulse = load(c.point[j].impulse);
    sum += impulse;
    angular_a = angular_a + load(c.point[j].angular_a) * impulse;
    angular_b = angular_b + load(c.point[j].angular_b) * impulse;
  }
  const Lanes3 t = t1 * load(c.tangent_impulse[0]) + t2 * load(c.tangent_impulse[1]);
  push(c, s, (n * sum + t) * scale, (angular_a + cross(load(c.center_a), t)) * scale,
       (angular_b + cross(load(c.center_b), t)) * scale);
}

void warm_start_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const ContactBatch& c = p.batches[i];
    Sides s;
    gather_velocity(p, c, s);
    push_impulses(c, p.sides[i], all_lanes(1), s);
    write_back(p, c, s);
  }
}

}  // namespace
}  // namespace feder

#include "rigid/strike_kernel.h"

namespace feder {
namespace {

// The normal rows of one batch; returns with the velocities of `s` changed and impulses stored.
template <bool kBiased>
[[gnu::always_inline]] inline Lanes solve_normals(const ContactPass& p, ContactBatch& c, const BatchSide& side,
                                                  Sides& s) {
  const Lanes3 n = load(c.normal);
  const Lanes along = dot(n, linear(s.b) - linear(s.a));
  const Lanes normal_displacement = dot(n, s.delta_position);
  const Lanes zero = zero_lanes(), inv_h = all_lanes(p.inv_h);
  const LaneMask fixed = load(c.against_fixed) > zero;
  const Lanes rate = select(fixed, all_lanes(p.soft_fixed.bias_rate), all_lanes(p.soft.bias_rate));
  const Lanes mass_scale = select(fixed, all_lanes(p.soft_fixed.mass_scale), all_lanes(p.soft.mass_scale));
  const Lanes leak = load(c.leak), leak_mean = load(c.leak_mean);
  Lanes speed[kBatchPoints], separation[kBatchPoints], before[kBatchPoints], all = zero;
  const unsigned count = c.points;
  for (unsigned j = 0; j < count; ++j) {
    const BatchPoint& q = c.point[j];
    speed[j] = point_speed(q, along, angular(s.a), angular(s.b));
    separation[j] = point_speed(q, load(q.separation) + normal_displacement, s.delta_rotation_a, s.delta_rotation_b);
    before[j] = load(q.impulse);
    all += before[j];
  }
  // after the motion of the substep: what is about to strike keeps its speed
  if (!kBiased && side.bounces)
    for (unsigned j = 0; j < count; ++j)
      separation[j] =
          select((load(side.restitution) > zero) & (separation[j] > zero) & (speed[j] < all_lanes(-p.bounce_speed)),
                 all_lanes(kFar), separation[j]);
  // one point: its impulse, and the speeds of all by the couplings
  Lanes stiffness[kBatchPoints];
  for (unsigned j = 0; j < count; ++j) stiffness[j] = reciprocal_or_zero(load(c.point[j].mass));
  const auto visit = [&](unsigned j, unsigned known) __attribute__((always_inline)) {
    BatchPoint& q = c.point[j];
    const LaneMask open = separation[j] > zero;  // may close the gap in this substep, not more
    const Lanes old = load(q.impulse);
    Lanes wanted;
    if constexpr (kBiased) {
      const Lanes bias = select(open, separation[j] * inv_h, max(separation[j] * rate, all_lanes(-p.push_speed)));
      const Lanes excess = select(open, speed[j] + bias, mass_scale * (speed[j] + bias) - leak_mean * all);
      wanted = old - load(q.mass) * excess - select(open, zero, leak) * old;
    } else {
      wanted = old - load(q.mass) * (speed[j] + select(open, separation[j] * inv_h, zero));
    }
    const Lanes now = max(wanted, zero);
    const Lanes change = now - old;
    store(q.impulse, now);
    if constexpr (kBiased) all += change;
    for (unsigned k = 0; k < known; ++k) speed[k] += (k == j ? stiffness[j] : load(c.coupling[kPair[j][k]])) * change;
  };
  // symmetric sweeps, forward and backward, so that no corner is favoured: a one-directional sweep tilts flat landings,
  // and stacks lean. The remaining error points from the first corner to the opposite one: sweeps start at both
  // alternately, so that it cancels
  const unsigned half = (kBiased == (p.odd != 0)) ? count / 2 : 0;
  const auto sweep = [&](unsigned known) __attribute__((always_inline)) {
    for (unsigned round = 0; round < c.rounds; ++round) {
      for (unsigned j = half; j < known; ++j) visit(j, known);
      for (unsigned j = 0; j < half; ++j) visit(j, known);
      for (unsigned j = half; j-- > 0;) visit(j, known);
      for (unsigned j = known; j-- > half;) visit(j, known);
    }
  };
  if (count == kBatchPoints) {
    sweep(kBatchPoints);  // faces: loops of known length
  } else {
    sweep(count);
  }
  // over-relaxed impulses into the velocities
  Lanes sum = zero, held = zero;
  Lanes3 angular_a{}, angular_b{};
  for (unsigned j = count; j-- > 0;) {
    BatchPoint& q = c.point[j];
    Lanes now = load(q.impulse);
    if constexpr (!kBiased) {
      now = max(before[j] + load(c.over) * (now - before[j]), zero);
      store(q.impulse, now);
    }
    const Lanes change = now - before[j];
    held += now;
    sum += change;
    angular_a = angular_a + load(q.angular_a) * change;
    angular_b = angular_b + load(q.angular_b) * change;
  }
  push(c, s, n * sum, angular_a, angular_b);
  return held;
}

// Torque against rolling, at most arm x normal impulse.
[[gnu::always_inline]] inline void relax_rolling(const ContactBatch& c, BatchSide& side, Lanes held, Sides& s) {
  const Lanes3 old = load(side.rolling_impulse);
  Lanes3 now = old - times(side.rolling_mass, angular(s.b) - angular(s.a));
  const Lanes limit = load(side.rolling_arm) * held;
  const Lanes size = square_root(dot(now, now));
  const LaneMask over = size > limit;
  now = now * select(over, limit / select(over, size, all_lanes(1)), all_lanes(1));
  store(side.rolling_impulse, now);
  const Lanes3 change = now - old;
  push(c, s, Lanes3{}, change, change);
}

[[gnu::always_inline]] inline void relax_twist(ContactBatch& c, Sides& s) {
  const Lanes3 n = load(c.normal);
  Lanes limit = zero_lanes();
  for (unsigned j = 0; j < c.points; ++j) limit += load(c.radius[j]) * load(c.point[j].impulse);
  limit *= load(c.friction_dynamic);
  const Lanes old = load(c.twist_impulse);
  const Lanes wanted = old - load(c.twist_mass) * dot(n, angular(s.b) - angular(s.a));
  const Lanes now = max(-limit, min(wanted, limit));
  store(c.twist_impulse, now);
  const Lanes3 change = n * (now - old);
  push(c, s, Lanes3{}, change, change);
}

// Coulomb friction of a manifold as a whole. An impulse beyond the static cone is clamped to it; one beyond kSlip times
// the static limit means that the manifold slides, with the dynamic cone. In between, slip below (kSlip - 1) mu_s g h
// is an error of the iteration (normals or neighbours not solved yet), which static friction removes. Returns whether
// another round is worth it: friction against an immovable body that matters, and may stick, still changes. Between two
// solver bodies the neighbours are no better converged than that.
template <bool kBiased>
[[gnu::always_inline]] inline bool relax_friction(ContactBatch& c, Lanes held, Sides& s) {
  const Lanes3 n = load(c.normal), t1 = load(c.tangent), t2 = cross(n, t1);
  const Lanes3 ra = load(c.center_a), rb = load(c.center_b);
  const Lanes3 v = linear(s.b) + cross(angular(s.b), rb) - linear(s.a) - cross(angular(s.a), ra);
  const Lanes v1 = dot(v, t1) - load(c.tangent_speed[0]), v2 = dot(v, t2) - load(c.tangent_speed[1]);
  const Lanes old1 = load(c.tangent_impulse[0]), old2 = load(c.tangent_impulse[1]);
  const Lanes m11 = load(c.tangent_mass[0]), m12 = load(c.tangent_mass[1]), m22 = load(c.tangent_mass[2]);
  const Lanes part = all_lanes(kBiased ? kBiasFriction : 1);
  Lanes now1 = old1 - part * (m11 * v1 + m12 * v2), now2 = old2 - part * (m12 * v1 + m22 * v2);
  const Lanes size = square_root(now1 * now1 + now2 * now2), limit = load(c.friction_static) * held;
  const LaneMask beyond = size > limit, slides = size > all_lanes(kSlip) * limit;
  const Lanes cone = select(slides, load(c.friction_dynamic) * held, limit);
  const Lanes scale = select(beyond, cone / select(beyond, size, all_lanes(1)), all_lanes(1));
  now1 = now1 * scale, now2 = now2 * scale;
  store(c.tangent_impulse[0], now1);
  store(c.tangent_impulse[1], now2);
  const Lanes d1 = now1 - old1, d2 = now2 - old2;
  const Lanes3 change = t1 * d1 + t2 * d2;
  push(c, s, change, cross(ra, change), cross(rb, change));
  const Lanes most = max(max(d1, -d1), max(d2, -d2));
  return any((most > all_lanes(kLoadPart) * limit) & (size > all_lanes(kLightPart) * limit) & ~slides &
             (load(c.against_fixed) > zero_lanes()));
}

// Friction here too, so that sideways sway of large piles is followed twice as well: a pyramid of 100 comes to rest
// three times sooner, and columns of 100 stand. It reacts to bias velocities, which grows in pyramids that are barely
// stable, so it is solved in part.
void solve_batches(const ContactPass& p) {
  FEDER_ASSERT(p.h > 0 && p.first <= p.last);
  for (unsigned i = p.first; i < p.last; ++i) {
    ContactBatch& c = p.batches[i];
    FEDER_ASSERT(c.rounds >= 1);
    Sides s;
    gather_velocity(p, c, s);
    gather_displacement(p, c, s);
    const Lanes held = solve_normals<true>(p, c, p.sides[i], s);
    relax_friction<true>(c, held, s);
    write_back(p, c, s);
  }
}

void relax_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    ContactBatch& c = p.batches[i];
    BatchSide& side = p.sides[i];
    Sides s;
    gather_velocity(p, c, s);
    gather_displacement(p, c, s);
    // sudden load: friction rotates the bodies, which shifts the normal impulses, which limit friction
    for (unsigned round = 0; round < kLoadRounds; ++round) {
      const Lanes held = solve_normals<false>(p, c, side, s);
      if (side.rolls) relax_rolling(c, side, held, s);
      relax_twist(c, s);
      if (!relax_friction<false>(c, held, s)) break;
    }
    write_back(p, c, s);
    for (unsigned j = 0; j < c.points; ++j) store(side.total[j], load(side.total[j]) + load(c.point[j].impulse));
  }
}

constexpr ContactKernels kKernels = {prepare_batches, renew_batches, warm_start_batches, mark_strikes, strike_batches,
                                     mark_thrown,     ease_batches,  solve_batches,      relax_batches};

}  // namespace
}  // namespace feder
