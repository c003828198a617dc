// Part of the contact kernels (contact_kernel.h): impacts within a substep, and what the warm start of jointed bodies
// throws.
#pragma once
#include "rigid/contact_kernel.h"

namespace feder {
namespace {

// Has the last wave of strikes changed a velocity of this batch?
bool was_struck(const ContactPass& p, const ContactBatch& c) {
  const unsigned char last = static_cast<unsigned char>(p.wave - 1);
  unsigned any = 0;
  for (int k = 0; k < kLanes; ++k)
    any |= unsigned(p.struck[c.index_a[k]] == last) | unsigned(p.struck[c.index_b[k]] == last);
  return any != 0;
}

// Notes the bodies of the lanes that strike.
void note_struck(const ContactPass& p, const ContactBatch& c, const StrikeBatch& strike) {
  Lanes most = zero_lanes();
  for (unsigned j = 0; j < c.points; ++j) most = min(most, load(strike.approach[j]));
  Lane8 speed;
  store(speed, most);
  for (int k = 0; k < kLanes; ++k) {
    if (!(speed.v[k] < 0)) continue;
    if (c.writes_a >> k & 1u) p.struck[c.index_a[k]] = p.wave;
    if (c.writes_b >> k & 1u) p.struck[c.index_b[k]] = p.wave;
  }
}

// Which points strike now: with restitution (or all), faster than bounce_speed, and in contact before the substep ends.
// After the first wave only what that has changed, or has marks that must go, is looked at.
void mark_strikes(const ContactPass& p) {
  const Lanes zero = zero_lanes(), one = all_lanes(1), h = all_lanes(p.h);
  for (unsigned i = p.first; i < p.last; ++i) {
    if (!p.batches[i].bounces && !p.all_strike) continue;
    const ContactBatch& c = p.batches[i];
    StrikeBatch& strike = p.strikes[i];
    if (p.struck && p.wave > 1 && !strike.acts && !was_struck(p, c)) continue;
    strike.acts = 0;
    Sides s;
    gather_velocity(p, c, s);
    const Frame f = frame_of(c);
    const Closing speeds = speeds_of(f, c, s);
    Lanes fastest = zero;
    for (unsigned j = 0; j < c.points; ++j) fastest = min(fastest, point_closing(c.point[j], speeds));
    if (!any(fastest < all_lanes(-p.bounce_speed))) continue;
    gather_displacement(p, c, s);
    const Closing displacements = displacements_of(f, c, s);
    const Lanes bouncing = p.all_strike ? one : select(load(p.sides[i].restitution) > zero, one, zero);
    Lanes some = zero;
    for (unsigned j = 0; j < c.points; ++j) {
      const BatchPoint& q = c.point[j];
      const Lanes speed = point_closing(q, speeds);
      const Lanes separation = load(q.separation) + point_closing(q, displacements);
      const LaneMask hits = (speed < all_lanes(-p.bounce_speed)) & (separation + speed * h < zero);
      const Lanes approach = select(hits, speed, zero) * bouncing;
      some = min(some, approach * load(q.mass));
      store(strike.approach[j], approach);
      store(strike.impulse[j], zero);
    }
    store(strike.tangent[0], zero), store(strike.tangent[1], zero);
    strike.acts = any(some < zero);
  }
}

// Which points part now, faster than bounce_speed, by an impulse that they have: of jointed bodies only.
void mark_thrown(const ContactPass& p) {
  const Lanes zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    const ContactBatch& c = p.batches[i];
    StrikeBatch& strike = p.strikes[i];
    strike.acts = 0;
    Lane8 jointed;
    unsigned any_jointed = 0;
    for (int k = 0; k < kLanes; ++k) {
      const unsigned is = p.jointed[c.index_a[k]] | p.jointed[c.index_b[k]];
      jointed.v[k] = WideReal(is), any_jointed |= is;
    }
    if (!any_jointed) continue;
    Sides s;
    gather_velocity(p, c, s);
    const Closing speeds = speeds_of(frame_of(c), c, s);
    Lanes some = zero;
    for (unsigned j = 0; j < c.points; ++j) {
      const BatchPoint& q = c.point[j];
      const Lanes speed = point_closing(q, speeds);
      const LaneMask thrown = (speed > all_lanes(p.bounce_speed)) & (load(q.impulse) > zero);
      const Lanes parts = select(thrown, speed, zero) * load(jointed);
      some = max(some, parts * load(q.mass));
      store(strike.approach[j], -parts);
    }
    strike.acts = any(some > zero);
  }
}

// One round: they give back as much of their impulse as stops that, in the inertia that gave it.
void ease_batches(const ContactPass& p) {
  const Lanes zero = zero_lanes(), one = all_lanes(1);
  for (unsigned i = p.first; i < p.last; ++i) {
    const StrikeBatch& strike = p.strikes[i];
    if (!strike.acts) continue;
    ContactBatch& c = p.batches[i];
    Sides s;
    gather_velocity(p, c, s);
    const Frame f = frame_of(c);
    for (unsigned j = 0; j < c.points; ++j) {
      BatchPoint& q = c.point[j];
      const Lanes speed = point_closing(q, speeds_of(f, c, s));
      const Lanes thrown = select(load(strike.approach[j]) < zero, one, zero), old = load(q.impulse);
      const Lanes change = thrown * (max(old - max(load(q.mass) * speed, zero), zero) - old);
      store(q.impulse, old + change);
      Pressed pressed{};
      pressed.add(q, change);
      push_normal(f, c, p.extras[i], s, pressed);
    }
    write_back(p, c, s);
  }
}

// Friction of a strike: Coulomb's cone over the impulse `held` of its points so far.
[[gnu::always_inline]] inline void strike_friction(const Frame& f, const ContactBatch& c, const BatchExtra& extra,
                                                   StrikeBatch& strike, Lanes held, Sides& s) {
  const Lanes3 v = center_motion(c, linear(s.b) - linear(s.a), angular(s.a), angular(s.b));
  Lanes v1 = dot(v, f.t1), v2 = dot(v, f.t2);
  if (c.conveys) v1 = v1 - load(extra.tangent_speed[0]), v2 = v2 - load(extra.tangent_speed[1]);
  const Lanes old1 = load(strike.tangent[0]), old2 = load(strike.tangent[1]);
  const Lanes m11 = load(c.tangent_mass[0]), m12 = load(c.tangent_mass[1]), m22 = load(c.tangent_mass[2]);
  Lanes now1 = old1 - (m11 * v1 + m12 * v2), now2 = old2 - (m12 * v1 + m22 * v2);
  const Lanes size = square_root(now1 * now1 + now2 * now2);
  const LaneMask beyond = size > load(c.friction_static) * held;
  const Lanes one = all_lanes(1);
  const Lanes scale = select(beyond, load(c.friction_dynamic) * held / select(beyond, size, one), one);
  now1 = now1 * scale, now2 = now2 * scale;
  store(strike.tangent[0], now1), store(strike.tangent[1], now2);
  const Lanes3 change = f.t1 * (now1 - old1) + f.t2 * (now2 - old2);
  push(c, extra, s, change, cross(load(c.center_a), change), cross(load(c.center_b), change));
}

// One round: points that strike leave with restitution x the speed they came with (Newton's law), or faster.
void strike_batches(const ContactPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    if ((!p.batches[i].bounces && !p.all_strike) || !p.strikes[i].acts) continue;
    ContactBatch& c = p.batches[i];
    BatchSide& side = p.sides[i];
    StrikeBatch& strike = p.strikes[i];
    Sides s;
    gather_velocity(p, c, s);
    const Frame f = frame_of(c);
    const Closing speeds = speeds_of(f, c, s);
    const Lanes zero = zero_lanes(), e = load(side.restitution);
    Lanes speed[kBatchPoints];
    for (unsigned j = 0; j < c.points; ++j) speed[j] = point_closing(c.point[j], speeds);
    Lanes held = zero;
    Pressed changes{};
    for (unsigned j = 0; j < c.points; ++j) {
      BatchPoint& q = c.point[j];
      const Lanes approach = load(strike.approach[j]), old = load(strike.impulse[j]);
      const Lanes wanted = max(old - load(q.mass) * (speed[j] + e * approach), zero);
      const Lanes now = select(approach < zero, wanted, zero), change = now - old;
      store(strike.impulse[j], now);
      store(side.total[j], load(side.total[j]) + change);
      held += now;
      changes.add(q, change);
      for (unsigned k = j + 1; k < c.points; ++k) speed[k] += load(c.coupling[kPair[j][k]]) * change;
    }
    push_normal(f, c, p.extras[i], s, changes);
    strike_friction(f, c, p.extras[i], strike, held, s);
    write_back(p, c, s);
    note_struck(p, c, strike);
  }
}

}  // namespace
}  // namespace feder
