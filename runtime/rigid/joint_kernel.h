// Joint kernels of the soft step: point joints, eight at a time. Included by joint_plain.cpp and joint_avx2.cpp, which
// differ in compiler flags only and give the same bits.
//
// The same rows as soft_joints.cpp solves one by one (WideRows::point of constrain/joint.h): C = anchor b - anchor a,
// bias towards closing it, the bend of both anchors by the rotation of the substep (bend_matrix), K = J M^-1 J^T by
// L D L^T. Arms, gaps and K are those of the poses now, in every substep: eight wide they cost less than keeping them
// would, and nothing drifts. The gap is a difference of displacements on top of that at the start of the step, so that
// distance from the origin costs no digits. Weak spot: joints of a colour do not see each other, so that a long loop
// takes more passes than in a sweep along it.
#pragma once
#include "rigid/joint_batch.h"

namespace feder {
namespace {

using namespace lanes;

constexpr int kJointStride = 16;  // numbers per solver body

// One half of eight solver bodies (SolverBody): row 0 holds v, w and the first two of delta_position; row 1 the third,
// delta_rotation and rotation.
[[gnu::always_inline]] inline void take_rows(const WideReal* bodies, const unsigned* index, int row,
                                             Lanes (&out)[kLanes]) {
  for (int i = 0; i < kLanes; ++i) out[i] = load_row(bodies + index[i] * kJointStride + row * kLanes);
  transpose(out);
}

[[gnu::always_inline]] inline void put_rows(WideReal* bodies, const unsigned* index, unsigned writes,
                                            Lanes (&rows)[kLanes]) {
  transpose(rows);
  for (int i = 0; i < kLanes; ++i)
    if (writes >> i & 1u) store_row(bodies + index[i] * kJointStride, rows[i]);
}

[[gnu::always_inline]] inline Lanes3 symmetric_times(const Lane8* m, const Lanes3& a) {
  const Lanes xx = load(m[0]), yy = load(m[1]), zz = load(m[2]), xy = load(m[3]), xz = load(m[4]), yz = load(m[5]);
  return {xx * a.x + xy * a.y + xz * a.z, xy * a.x + yy * a.y + yz * a.z, xz * a.x + yz * a.y + zz * a.z};
}

[[gnu::always_inline]] inline Lanes3 by_axis(const Lanes3& a, const Lanes3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

// v rotated by the unit quaternion (u, w).
[[gnu::always_inline]] inline Lanes3 turned(const Lanes3& u, Lanes w, const Lanes3& v) {
  const Lanes3 twice = cross(u, v) * all_lanes(2);
  return v + twice * w + cross(u, twice);
}

// Both sides of a batch: velocities now, in the rows they came in.
struct JointSides {
  Lanes a[kLanes], b[kLanes];
};

[[gnu::always_inline]] inline Lanes3 linear_of(const Lanes (&rows)[kLanes]) { return {rows[0], rows[1], rows[2]}; }
[[gnu::always_inline]] inline Lanes3 angular_of(const Lanes (&rows)[kLanes]) { return {rows[3], rows[4], rows[5]}; }
[[gnu::always_inline]] inline void add_to(Lanes (&rows)[kLanes], const Lanes3& v, const Lanes3& w) {
  rows[0] += v.x, rows[1] += v.y, rows[2] += v.z, rows[3] += w.x, rows[4] += w.y, rows[5] += w.z;
}

[[gnu::always_inline]] inline void load_sides(const JointPass& p, const PointJointBatch& c, JointSides& s) {
  take_rows(p.bodies, c.index_a, 0, s.a);
  take_rows(p.bodies, c.index_b, 0, s.b);
}

[[gnu::always_inline]] inline void store_sides(const JointPass& p, const PointJointBatch& c, JointSides& s) {
  put_rows(p.bodies, c.index_a, c.writes_a, s.a);
  put_rows(p.bodies, c.index_b, c.writes_b, s.b);
}

// Velocities changed by the impulse `l` on b at its anchor, and the opposite one on a.
[[gnu::always_inline]] inline void push_point_joint(const PointJointBatch& c, JointSides& s, const Lanes3& l) {
  const Lanes3 ta = symmetric_times(c.inv_inertia_a, cross(l, load(c.moment_a)) * load(c.share_a));
  const Lanes3 tb = symmetric_times(c.inv_inertia_b, cross(load(c.moment_b), l) * load(c.share_b));
  add_to(s.a, by_axis(load(c.inv_mass_a), Lanes3{-l.x, -l.y, -l.z}), ta);
  add_to(s.b, by_axis(load(c.inv_mass_b), l), tb);
}

// Displacement of an arm by the rotation of a substep beyond its straight motion, over h: bend_matrix(w, w, h) arm.
[[gnu::always_inline]] inline Lanes3 bend_of(const Lanes3& w, const Lanes3& arm, WideReal h) {
  const auto c = [](double x) { return all_lanes(static_cast<WideReal>(x)); };
  const Lanes w2 = dot(w, w), x2 = w2 * all_lanes(h * h);
  const Lanes inward = all_lanes(h) / (c(2) + x2 * c(1.0 / 6)), slower = x2 / (c(6) + c(0.3) * x2);
  return (w * dot(w, arm) - arm * w2) * inward - cross(w, arm) * slower;
}

// Adds [arm]x I [arm]x^T, lower triangle 00 11 22 10 20 21.
[[gnu::always_inline]] inline void add_response(const Lane8* inertia, Lanes share, const Lanes3& r, Lanes (&k)[6]) {
  const Lanes zero = zero_lanes();
  const Lanes3 p0 = symmetric_times(inertia, Lanes3{zero, r.z, -r.y}) * share;
  const Lanes3 p1 = symmetric_times(inertia, Lanes3{-r.z, zero, r.x}) * share;
  const Lanes3 p2 = symmetric_times(inertia, Lanes3{r.y, -r.x, zero}) * share;
  k[0] += r.z * p0.y - r.y * p0.z;
  k[1] += r.x * p1.z - r.z * p1.x;
  k[2] += r.y * p2.x - r.x * p2.y;
  k[3] += r.x * p0.z - r.z * p0.x;
  k[4] += r.y * p0.x - r.x * p0.y;
  k[5] += r.y * p1.x - r.x * p1.y;
}

// The inverse; a vanishing pivot (locked axis, empty lane) takes no part.
[[gnu::always_inline]] inline Lanes inverse_pivot(Lanes pivot, Lanes diagonal) {
  const LaneMask good = pivot > diagonal * all_lanes(static_cast<WideReal>(1e-5));
  return select(good, all_lanes(1) / select(good, pivot, all_lanes(1)), zero_lanes());
}

[[gnu::always_inline]] inline void factor_joint(const Lanes (&k)[6], Lane8 (&out)[6]) {
  const Lanes d0 = inverse_pivot(k[0], k[0]), l10 = k[3] * d0, l20 = k[4] * d0;
  const Lanes d1 = inverse_pivot(k[1] - k[3] * l10, k[1]), u21 = k[5] - k[4] * l10, l21 = u21 * d1;
  const Lanes d2 = inverse_pivot(k[2] - k[4] * l20 - u21 * l21, k[2]);
  store(out[0], d0), store(out[1], d1), store(out[2], d2);
  store(out[3], l10), store(out[4], l20), store(out[5], l21);
}

[[gnu::always_inline]] inline Lanes3 solve_joint(const Lane8 (&f)[6], Lanes3 x) {
  const Lanes l10 = load(f[3]), l20 = load(f[4]), l21 = load(f[5]);
  x.y -= l10 * x.x;
  x.z -= l20 * x.x + l21 * x.y;
  x.x = x.x * load(f[0]), x.y = x.y * load(f[1]), x.z = x.z * load(f[2]);
  x.y -= l21 * x.z;
  x.x -= l10 * x.y + l20 * x.z;
  return x;
}

[[gnu::always_inline]] inline Lanes3 joint_speed(const PointJointBatch& c, const JointSides& s) {
  return linear_of(s.b) - linear_of(s.a) + cross(angular_of(s.b), load(c.moment_b)) -
         cross(angular_of(s.a), load(c.moment_a));
}

void start_joints(const JointPass& p) {
  for (unsigned n = p.first; n < p.last; ++n) {
    PointJointBatch& c = p.batches[n];
    JointSides s;
    Lanes a[kLanes], b[kLanes];
    load_sides(p, c, s);
    take_rows(p.bodies, c.index_a, 1, a);
    take_rows(p.bodies, c.index_b, 1, b);
    for (int i = 0; i < kLanes; ++i) c.share_a.v[i] = p.share[c.index_a[i]], c.share_b.v[i] = p.share[c.index_b[i]];
    // anchors
    const Lanes3 arm_a = turned(Lanes3{a[4], a[5], a[6]}, a[7], load(c.local_a));
    const Lanes3 arm_b = turned(Lanes3{b[4], b[5], b[6]}, b[7], load(c.local_b));
    const Lanes3 moved{s.b[6] - s.a[6], s.b[7] - s.a[7], b[0] - a[0]};
    const Lanes3 gap = load(c.start_gap) + moved + (arm_b - arm_a);
    store(c.moment_a, arm_a);
    store(c.moment_b, arm_b);
    // bias; a gap that would close too fast closes at push_speed, with the impulse scaled likewise (bound_bias)
    const Lanes3 closing = gap * all_lanes(p.soft.bias_rate);
    const Lanes speed2 = dot(closing, closing), most = all_lanes(p.push_speed);
    const LaneMask fast = speed2 > most * most;
    Lanes part = all_lanes(1);
    if (any(fast)) part = select(fast, most / square_root(select(fast, speed2, part)), part);
    store(c.closing, closing * part);
    store(c.impulse, load(c.impulse) * part);
    store(c.bend, bend_of(angular_of(s.b), arm_b, p.h) * load(c.bends_b) -
                      bend_of(angular_of(s.a), arm_a, p.h) * load(c.bends_a));
    // effective mass
    const Lanes3 inv_mass = load(c.inv_mass_a) + load(c.inv_mass_b);
    Lanes k[6] = {inv_mass.x, inv_mass.y, inv_mass.z, zero_lanes(), zero_lanes(), zero_lanes()};
    add_response(c.inv_inertia_a, load(c.share_a), arm_a, k);
    add_response(c.inv_inertia_b, load(c.share_b), arm_b, k);
    factor_joint(k, c.factor);
  }
}

void warm_start_joints(const JointPass& p) {
  for (unsigned n = p.first; n < p.last; ++n) {
    const PointJointBatch& c = p.batches[n];
    JointSides s;
    load_sides(p, c, s);
    push_point_joint(c, s, load(c.impulse));
    store_sides(p, c, s);
  }
}

void solve_joints(const JointPass& p) {
  const Lanes mass_scale = all_lanes(p.soft.mass_scale), impulse_scale = all_lanes(p.soft.impulse_scale);
  for (unsigned n = p.first; n < p.last; ++n) {
    PointJointBatch& c = p.batches[n];
    JointSides s;
    load_sides(p, c, s);
    const Lanes3 x = solve_joint(c.factor, joint_speed(c, s) + load(c.closing) + load(c.bend));
    const Lanes3 old = load(c.impulse);
    const Lanes3 step = Lanes3{-x.x, -x.y, -x.z} * mass_scale - old * impulse_scale;
    store(c.impulse, old + step);
    push_point_joint(c, s, step);
    store_sides(p, c, s);
  }
}

void relax_joints(const JointPass& p) {
  for (unsigned n = p.first; n < p.last; ++n) {
    PointJointBatch& c = p.batches[n];
    JointSides s;
    load_sides(p, c, s);
    const Lanes3 x = solve_joint(c.factor, joint_speed(c, s) + load(c.bend));
    const Lanes3 now = load(c.impulse) - x;
    store(c.impulse, now);
    push_point_joint(c, s, Lanes3{-x.x, -x.y, -x.z});
    store_sides(p, c, s);
    // strain of the next substep
    const Lanes pull = square_root(dot(now, now)) * all_lanes(p.h);
    Lane8 a, b;
    store(a, pull * load(c.arm_a)), store(b, pull * load(c.arm_b));
    for (int i = 0; i < kLanes; ++i) {
      if (c.writes_a >> i & 1u) p.strain[c.index_a[i]] += a.v[i];
      if (c.writes_b >> i & 1u) p.strain[c.index_b[i]] += b.v[i];
    }
  }
}

}  // namespace
}  // namespace feder
