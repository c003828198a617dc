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
#include "base/prefetch.h"
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

// The normal and its tangents: tangent_frame of feder/types.h (Duff et al. 2017).
struct Frame {
  Lanes3 n, t1, t2;
};

[[gnu::always_inline]] inline Frame frame_of(const ContactBatch& c) {
  const Lanes3 n = load(c.normal);
  const Lanes one = all_lanes(1);
  const Lanes sign = select(n.z < zero_lanes(), -one, one);
  const Lanes s = -one / (sign + n.z);
  const Lanes3 t1{one + sign * n.x * n.x * s, sign * n.x * n.y * s, -sign * n.x};
  return {n, t1, cross(n, t1)};
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
[[gnu::always_inline]] inline void push(const ContactBatch& c, const BatchExtra& extra, Sides& s, const Lanes3& l,
                                        const Lanes3& angular_a, const Lanes3& angular_b) {
  Lanes3 la = l * load(c.inv_mass_a), lb = l * load(c.inv_mass_b);
  if (c.locked) la = times(load(extra.axes_a), l), lb = times(load(extra.axes_b), l);
  put(s.a, linear(s.a) - la, angular(s.a) - times(c.inv_inertia_a, angular_a));
  put(s.b, linear(s.b) + lb, angular(s.b) + times(c.inv_inertia_b, angular_b));
}

// What a linear impulse through the centres would change of b's velocity against a's.
[[gnu::always_inline]] inline Lanes3 parting_of(const ContactBatch& c, const BatchExtra& extra, const Lanes3& l) {
  const Lanes3 all = l * (load(c.inv_mass_a) + load(c.inv_mass_b));
  return c.locked ? times(load(extra.axes_a) + load(extra.axes_b), l) : all;
}

// The same as `push` for an angular impulse alone.
[[gnu::always_inline]] inline void turn(const ContactBatch& c, Sides& s, const Lanes3& change) {
  const Lanes3 a = angular(s.a) - times(c.inv_inertia_a, change), b = angular(s.b) + times(c.inv_inertia_b, change);
  put(s.a, linear(s.a), a);
  put(s.b, linear(s.b), b);
}

[[gnu::always_inline]] inline void write_back(const ContactPass& p, const ContactBatch& c, Sides& s) {
  if (c.writes_a) scatter(p.bodies, c.index_a, c.writes_a, s.a);
  if (c.writes_b) scatter(p.bodies, c.index_b, c.writes_b, s.b);
}

[[gnu::always_inline]] inline Lanes reciprocal_or_zero(Lanes k) {
  const LaneMask good = k > zero_lanes();
  return select(good, all_lanes(1) / select(good, k, all_lanes(1)), zero_lanes());
}

constexpr int kPair[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

// Of b against a: the velocity of the manifold's centre, from the linear part `v`. Displacements likewise.
[[gnu::always_inline]] inline Lanes3 center_motion(const ContactBatch& c, const Lanes3& v, const Lanes3& wa,
                                                   const Lanes3& wb) {
  return v + cross(wb, load(c.center_b)) - cross(wa, load(c.center_a));
}

// Motion along the normal: of the centre, and what it is more per metre along t2 and less per metre along t1.
struct Closing {
  Lanes center, along2, along1;
};

[[gnu::always_inline]] inline Closing closing_of(const Frame& f, const Lanes3& center, const Lanes3& turn) {
  return {dot(f.n, center), dot(f.t1, turn), dot(f.t2, turn)};
}
[[gnu::always_inline]] inline Closing speeds_of(const Frame& f, const ContactBatch& c, const Sides& s) {
  return closing_of(f, center_motion(c, linear(s.b) - linear(s.a), angular(s.a), angular(s.b)),
                    angular(s.b) - angular(s.a));
}
[[gnu::always_inline]] inline Closing displacements_of(const Frame& f, const ContactBatch& c, const Sides& s) {
  return closing_of(f, center_motion(c, s.delta_position, s.delta_rotation_a, s.delta_rotation_b),
                    s.delta_rotation_b - s.delta_rotation_a);
}
[[gnu::always_inline]] inline Lanes point_closing(const BatchPoint& q, const Closing& m) {
  return m.center + load(q.y) * m.along2 - load(q.x) * m.along1;
}

// Normal impulses of the points: their sum, and its moments x and y.
struct Pressed {
  Lanes sum, x, y;

  [[gnu::always_inline]] void add(const BatchPoint& q, Lanes impulse) {
    sum += impulse, x += load(q.x) * impulse, y += load(q.y) * impulse;
  }
};

[[gnu::always_inline]] inline void push_normal(const Frame& f, const ContactBatch& c, const BatchExtra& extra, Sides& s,
                                               const Pressed& p) {
  const Lanes3 l = f.n * p.sum, off = f.t1 * p.y - f.t2 * p.x;
  push(c, extra, s, l, cross(load(c.center_a), l) + off, cross(load(c.center_b), l) + off);
}

}  // namespace
}  // namespace feder

#include "rigid/contact_prepare.h"
#include "rigid/strike_kernel.h"

namespace feder {
namespace {

// Velocity change by the impulses of a batch.
[[gnu::always_inline]] inline void push_impulses(const ContactBatch& c, const BatchExtra& extra, Sides& s) {
  const Frame f = frame_of(c);
  Pressed pressed{};
  for (unsigned j = 0; j < c.points; ++j) pressed.add(c.point[j], load(c.point[j].impulse));
  const Lanes3 l = f.n * pressed.sum + f.t1 * load(c.tangent_impulse[0]) + f.t2 * load(c.tangent_impulse[1]);
  Lanes3 off = f.t1 * pressed.y - f.t2 * pressed.x + f.n * load(c.twist_impulse);
  if (c.rolls) off = off + load(extra.rolling_impulse);
  push(c, extra, s, l, cross(load(c.center_a), l) + off, cross(load(c.center_b), l) + off);
}

void warm_start_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const ContactBatch& c = p.batches[i];
    Sides s;
    gather_velocity(p, c, s);
    push_impulses(c, p.extras[i], s);
    write_back(p, c, s);
  }
}

// f(j) for the numbers from kFirst to kLast - 1, or down from kLast - 1, known to the compiler: what they index stays
// in registers.
template <int kNumber>
struct Index {
  constexpr operator int() const { return kNumber; }
};
template <int kFirst, int kLast, class F>
[[gnu::always_inline]] inline void each_up(F&& f) {
  if constexpr (kFirst < kLast) f(Index<kFirst>{}), each_up<kFirst + 1, kLast>(f);
}
template <int kFirst, int kLast, class F>
[[gnu::always_inline]] inline void each_down(F&& f) {
  if constexpr (kFirst < kLast) f(Index<kLast - 1>{}), each_down<kFirst, kLast - 1>(f);
}

// The normal rows of a batch while they are solved, its points taken as kCount.
template <bool kBiased, int kCount>
struct Normals {
  Lanes speed[kCount];                     // closing, and bias: what a point wants to lose, m/s
  Lanes gain[kCount], stiffness[kCount];   // effective mass, with bias softened, kg; and 1 over it
  Lanes before[kCount], impulse[kCount];   // at first and now, N s
  Lanes keep[kCount], share[kCount], all;  // with bias: compliance keeps that of a point's own impulse, and gives
                                           // that of the sum `all`
};

template <bool kBiased, int kCount>
[[gnu::always_inline]] inline void begin_normals(const ContactPass& p, const Frame& f, const ContactBatch& c,
                                                 const BatchSide& side, const Sides& s, Normals<kBiased, kCount>& x) {
  const Closing speeds = speeds_of(f, c, s), displacements = displacements_of(f, c, s);
  const Lanes zero = zero_lanes(), one = all_lanes(1), inv_h = all_lanes(p.inv_h);
  const LaneMask fixed = mask_of(c.fixed);
  const Lanes rate = select(fixed, all_lanes(p.soft_fixed.bias_rate), all_lanes(p.soft.bias_rate));
  const Lanes mass_scale = select(fixed, all_lanes(p.soft_fixed.mass_scale), all_lanes(p.soft.mass_scale));
  const Lanes kept = one - load(c.leak), leak_mean = load(c.leak_mean);
  x.all = zero;
  each_up<0, kCount>([&](auto j) __attribute__((always_inline)) {
    const BatchPoint& q = c.point[j];
    const Lanes mass = load(q.mass), closing = point_closing(q, speeds);
    Lanes separation = load(q.separation) + point_closing(q, displacements);
    // after the motion of the substep: what is about to strike keeps its speed
    if (!kBiased && c.bounces)
      separation =
          select((load(side.restitution) > zero) & (separation > zero) & (closing < all_lanes(-p.bounce_speed)),
                 all_lanes(kFar), separation);
    const LaneMask open = separation > zero;  // may close the gap in this substep, not more
    const Lanes gap = separation * inv_h;
    if constexpr (kBiased) {
      x.speed[j] = closing + select(open, gap, max(separation * rate, all_lanes(-p.push_speed)));
      x.gain[j] = select(open, mass, mass * mass_scale);
      x.keep[j] = select(open, one, kept);
      x.share[j] = select(open, zero, mass * leak_mean);
    } else {
      x.speed[j] = closing + select(open, gap, zero);
      x.gain[j] = mass;
    }
    x.stiffness[j] = reciprocal_or_zero(mass);
    x.before[j] = x.impulse[j] = load(q.impulse);
    x.all += x.impulse[j];
  });
}

// One point: its impulse, and the speeds of all by the couplings.
template <int kPoint, bool kBiased, int kCount>
[[gnu::always_inline]] inline void visit(const ContactBatch& c, Normals<kBiased, kCount>& x) {
  const Lanes old = x.impulse[kPoint];
  Lanes wanted = old;
  if constexpr (kBiased) wanted = x.keep[kPoint] * old + x.share[kPoint] * x.all;
  const Lanes now = max(wanted - x.gain[kPoint] * x.speed[kPoint], zero_lanes()), change = now - old;
  x.impulse[kPoint] = now;
  if constexpr (kBiased) x.all += change;
  each_up<0, kCount>([&](auto k) __attribute__((always_inline)) {
    x.speed[k] += (k == kPoint ? x.stiffness[k] : load(c.coupling[kPair[kPoint][k]])) * change;
  });
}

// Symmetric sweeps, forward and backward, so that no corner is favoured: a one-directional sweep tilts flat landings,
// and stacks lean. The remaining error points from the first corner to the opposite one: sweeps start at both
// alternately (kHalf), so that it cancels.
template <int kHalf, bool kBiased, int kCount, int kWide>
[[gnu::always_inline]] inline void sweep(ContactBatch* c, Normals<kBiased, kCount> (&x)[kWide]) {
  const auto each = [&](auto j) __attribute__((always_inline)) {
    each_up<0, kWide>([&](auto i) __attribute__((always_inline)) { visit<j>(c[i], x[i]); });
  };
  each_up<kHalf, kCount>(each);
  each_up<0, kHalf>(each);
  each_down<0, kHalf>(each);
  each_down<kHalf, kCount>(each);
}

// Over-relaxed impulses into the velocities: of what rests, where one relax pass has to remove the bias. Returns the
// sum of the impulses.
template <bool kBiased, int kCount>
[[gnu::always_inline]] inline Lanes end_normals(const Frame& f, ContactBatch& c, const BatchExtra& extra,
                                                Normals<kBiased, kCount>& x, Sides& s) {
  const Lanes over = select(~mask_of(c.fixed) & mask_of(c.warm), all_lanes(kOver), all_lanes(1));
  Lanes held = zero_lanes();
  Pressed changes{};
  each_up<0, kCount>([&](auto j) __attribute__((always_inline)) {
    Lanes now = x.impulse[j];
    if constexpr (!kBiased) now = max(x.before[j] + over * (now - x.before[j]), zero_lanes());
    store(c.point[j].impulse, now);
    held += now;
    changes.add(c.point[j], now - x.before[j]);
  });
  push_normal(f, c, extra, s, changes);
  return held;
}

// The normal rows of kWide batches side by side, which share no solver body: one waits for its own results only.
template <bool kBiased, int kCount, int kWide>
[[gnu::always_inline]] inline void solve_normals(const ContactPass& p, unsigned first, const Frame (&f)[kWide],
                                                 Sides (&s)[kWide], Lanes (&held)[kWide]) {
  ContactBatch* c = p.batches + first;
  const BatchSide* side = p.sides + first;
  const BatchExtra* extra = p.extras + first;
  Normals<kBiased, kCount> x[kWide];
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) { begin_normals(p, f[i], c[i], side[i], s[i], x[i]); });
  for (unsigned round = 0; round < c->rounds; ++round) {
    if (kBiased == (p.odd != 0))
      sweep<kCount / 2>(c, x);
    else
      sweep<0>(c, x);
  }
  each_up<0, kWide>([&](auto i)
                        __attribute__((always_inline)) { held[i] = end_normals(f[i], c[i], extra[i], x[i], s[i]); });
}

// Torque against rolling, at most arm x normal impulse.
[[gnu::always_inline]] inline void relax_rolling(const ContactBatch& c, BatchExtra& extra, Lanes held, Sides& s) {
  const Lanes3 old = load(extra.rolling_impulse);
  Lanes3 now = old - times(extra.rolling_mass, angular(s.b) - angular(s.a));
  const Lanes limit = load(extra.rolling_arm) * held;
  const Lanes size = square_root(dot(now, now));
  const LaneMask over = size > limit;
  now = now * select(over, limit / select(over, size, all_lanes(1)), all_lanes(1));
  store(extra.rolling_impulse, now);
  turn(c, s, now - old);
}

[[gnu::always_inline]] inline void relax_twist(const Frame& f, ContactBatch& c, Sides& s) {
  Lanes limit = zero_lanes();
  for (unsigned j = 0; j < c.points; ++j) {
    const BatchPoint& q = c.point[j];
    const Lanes x = load(q.x), y = load(q.y);
    limit += square_root(x * x + y * y) * load(q.impulse);
  }
  limit *= load(c.friction_dynamic);
  const Lanes old = load(c.twist_impulse);
  const Lanes wanted = old - load(c.twist_mass) * dot(f.n, angular(s.b) - angular(s.a));
  const Lanes now = max(-limit, min(wanted, limit));
  store(c.twist_impulse, now);
  turn(c, s, f.n * (now - old));
}

// Coulomb friction of a manifold as a whole. An impulse beyond the static cone is clamped to it; one beyond kSlip times
// the static limit means that the manifold slides, with the dynamic cone. In between, slip below (kSlip - 1) mu_s g h
// is an error of the iteration (normals or neighbours not solved yet), which static friction removes. Returns whether
// another round is worth it: friction against an immovable body that matters, and may stick, still changes. Between two
// solver bodies the neighbours are no better converged than that.
template <bool kBiased>
[[gnu::always_inline]] inline bool relax_friction(const Frame& f, ContactBatch& c, const BatchExtra& extra, Lanes held,
                                                  Sides& s) {
  const Lanes3 v = center_motion(c, linear(s.b) - linear(s.a), angular(s.a), angular(s.b));
  Lanes v1 = dot(v, f.t1), v2 = dot(v, f.t2);
  if (c.conveys) v1 = v1 - load(extra.tangent_speed[0]), v2 = v2 - load(extra.tangent_speed[1]);
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
  const Lanes3 change = f.t1 * d1 + f.t2 * d2;
  push(c, extra, s, change, cross(load(c.center_a), change), cross(load(c.center_b), change));
  const Lanes most = max(max(d1, -d1), max(d2, -d2));
  return any((most > all_lanes(kLoadPart) * limit) & (size > all_lanes(kLightPart) * limit) & ~slides &
             mask_of(c.fixed));
}

// Friction here too, so that sideways sway of large piles is followed twice as well: a pyramid of 100 comes to rest
// three times sooner, and columns of 100 stand. It reacts to bias velocities, which grows in pyramids that are barely
// stable, so it is solved in part.
template <int kCount, int kWide>
void solve_some(const ContactPass& p, unsigned first) {
  Sides s[kWide];
  Frame f[kWide];
  Lanes held[kWide];
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    gather_velocity(p, p.batches[first + i], s[i]);
    gather_displacement(p, p.batches[first + i], s[i]);
    f[i] = frame_of(p.batches[first + i]);
  });
  solve_normals<true, kCount, kWide>(p, first, f, s, held);
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    relax_friction<true>(f[i], p.batches[first + i], p.extras[first + i], held[i], s[i]);
  });
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) { write_back(p, p.batches[first + i], s[i]); });
}

// Sudden load: friction rotates the bodies, which shifts the normal impulses, which limit friction. Further rounds.
template <int kCount>
[[gnu::noinline]] void relax_loaded(const ContactPass& p, unsigned i) {
  ContactBatch& c = p.batches[i];
  BatchExtra& extra = p.extras[i];
  Sides s[1];
  Lanes held[1];
  gather_velocity(p, c, s[0]);
  gather_displacement(p, c, s[0]);
  const Frame f[1] = {frame_of(c)};
  for (unsigned round = 1; round < kLoadRounds; ++round) {
    solve_normals<false, kCount, 1>(p, i, f, s, held);
    if (c.rolls) relax_rolling(c, extra, held[0], s[0]);
    relax_twist(f[0], c, s[0]);
    if (!relax_friction<false>(f[0], c, extra, held[0], s[0])) break;
  }
  write_back(p, c, s[0]);
}

template <int kCount>
[[gnu::always_inline]] inline void add_totals(const ContactBatch& c, BatchSide& side, Lanes sign) {
  for (int j = 0; j < kCount; ++j) store(side.total[j], load(side.total[j]) + sign * load(c.point[j].impulse));
}

template <int kCount, int kWide>
void relax_some(const ContactPass& p, unsigned first) {
  ContactBatch* c = p.batches + first;
  BatchSide* side = p.sides + first;
  BatchExtra* extra = p.extras + first;
  Sides s[kWide];
  Frame f[kWide];
  Lanes held[kWide];
  bool again[kWide];
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    gather_velocity(p, c[i], s[i]);
    gather_displacement(p, c[i], s[i]);
    f[i] = frame_of(c[i]);
  });
  if (p.again)
    each_up<0, kWide>([&](auto i) __attribute__((always_inline)) { add_totals<kCount>(c[i], side[i], all_lanes(-1)); });
  solve_normals<false, kCount, kWide>(p, first, f, s, held);
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    if (c[i].rolls) relax_rolling(c[i], extra[i], held[i], s[i]);
    relax_twist(f[i], c[i], s[i]);
  });
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    again[i] = relax_friction<false>(f[i], c[i], extra[i], held[i], s[i]);
  });
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) { write_back(p, c[i], s[i]); });
  each_up<0, kWide>([&](auto i) __attribute__((always_inline)) {
    if (again[i]) relax_loaded<kCount>(p, first + i);
    add_totals<kCount>(c[i], side[i], all_lanes(1));
  });
}

// Calls f(count, wide, first) with the batches of the pass in order; alike neighbours of a colour are taken in twos.
template <class F>
[[gnu::always_inline]] inline void each_some(const ContactPass& p, F&& f) {
  const auto call = [&](auto count, unsigned i) __attribute__((always_inline)) {
    const ContactBatch &c = p.batches[i], &d = p.batches[i + 1];
    if (i + 4 <= p.fetched) prefetch(p.batches[i + 2]), prefetch(p.batches[i + 3]);
    if (!c.last_of_color && i + 1 < p.last && d.points == c.points && d.rounds == c.rounds)
      return f(count, Index<2>{}, i), 2u;
    return f(count, Index<1>{}, i), 1u;
  };
  for (unsigned i = p.first; i < p.last;) {
    if (p.batches[i].points == 1)
      i += call(Index<1>{}, i);
    else if (p.batches[i].points == 2)
      i += call(Index<2>{}, i);
    else
      i += call(Index<4>{}, i);
  }
}

void solve_batches(const ContactPass& p) {
  FEDER_ASSERT(p.h > 0 && p.first <= p.last);
  each_some(p, [&](auto count, auto wide, unsigned first) { solve_some<count, wide>(p, first); });
}

void relax_batches(const ContactPass& p) {
  each_some(p, [&](auto count, auto wide, unsigned first) { relax_some<count, wide>(p, first); });
}

constexpr ContactKernels kKernels = {prepare_batches, renew_batches, warm_start_batches, mark_strikes, strike_batches,
                                     mark_thrown,     ease_batches,  solve_batches,      relax_batches};

}  // namespace
}  // namespace feder
