// The arithmetic of links and hinges, eight at a time. Included by kernel_plain.cpp and kernel_avx2.cpp, which differ
// in compiler flags only and give the same bits.
// XPBD (Macklin et al. 2016, eq. 18): with alpha = compliance/h^2 and multiplier L,
//   dL = (-C - alpha L)/(sum w |grad C|^2 + alpha),  x += w grad C dL.
// Hinges use the angle itself (Bridson 2003; Tamstorf and Grinspun 2013 for the gradients), not the distance across.
// Positions are those at the start of the step plus displacements: what a solver substep adds is far below the rounding
// of a position, but not of a displacement.
#pragma once
#include "base/lane_rows.h"
#include "cloth/batch.h"

namespace feder {
namespace {

using namespace lanes;

// Length limit of this solver substep: `longest`, or, for an edge that was longer at its start, that length less what
// kShedSpeed takes back. Else an edge without compliance would give any energy to a vertex that a script moved away.
[[gnu::always_inline]] inline Lanes allowed(const ClothPass& p, Lanes longest, const Lanes3& before) {
  return max(longest, square_root(dot(before, before)) - all_lanes(kShedSpeed * p.h));
}

[[gnu::always_inline]] inline Lanes allowed(const ClothPass& p, const LinkBatch& c, Lanes longest) {
  return allowed(p, longest, load(c.base) + (gather(p.before, c.b).v - gather(p.before, c.a).v));
}

// Opposite corrections of both ends of a link, in kg m.
[[gnu::always_inline]] inline void push_ends(const ClothPass& p, const LinkBatch& c, Rows8& a, Rows8& b,
                                             const Lanes3& push) {
  a.v = a.v - push * a.w;
  b.v = b.v + push * b.w;
  scatter(p.delta_position, c.a, a);
  scatter(p.delta_position, c.b, b);
}

// XPBD rows of links. With a strain limit the row has no compliance where that pulls more: C = |e| - rest stretched <=
// 0.
// In a cloth that tension holds the moves of a row are undone by its neighbours', half of them after it: its length at
// the end is what a link with half of the inverse masses more compliance has. kTaut takes that off, down to none.
// kOnce: one sweep does, so multipliers are not kept.
template <bool kLimited, bool kTaut, bool kOnce>
void sweep_links(const ClothPass& p) {
  const Lanes inv_h2 = all_lanes(p.inv_h2);
  for (unsigned i = p.first; i < p.last; ++i) {
    LinkBatch& c = p.links[i];
    Rows8 a = gather(p.delta_position, c.a), b = gather(p.delta_position, c.b);
    const Lanes3 e = load(c.base) + (b.v - a.v);
    const Lanes size = square_root(dot(e, e));
    Lanes alpha = load(c.compliance) * inv_h2;
    if (kTaut) {
      const LaneMask both = (a.w > zero_lanes()) & (b.w > zero_lanes());
      alpha = max(alpha - select(both, all_lanes(0.5f) * (a.w + b.w), zero_lanes()), zero_lanes());
    }
    const Lanes old = !kOnce && p.again ? load(c.multiplier) : zero_lanes();
    Lanes pull = load(c.rest) - size - alpha * old, weight = a.w + b.w + alpha;
    if (kLimited) {
      const Lanes longest = load(c.rest) * all_lanes(p.stretched), stiff = a.w + b.w;
      if (any((longest - size) * weight < pull * stiff)) {
        const Lanes over = allowed(p, c, longest) - size;
        const LaneMask taut = over * weight < pull * stiff;
        pull = select(taut, over, pull), weight = select(taut, stiff, weight);
      }
    }
    const Lanes change = pull * reciprocal_or_zero(weight);
    if (!kOnce) store(c.multiplier, old + change);
    push_ends(p, c, a, b, e * (change * reciprocal_or_zero(size)));
  }
}

template <bool kLimited, bool kTaut = false>
void solve_links(const ClothPass& p) {
  p.once ? sweep_links<kLimited, kTaut, true>(p) : sweep_links<kLimited, kTaut, false>(p);
}

// Strain limit alone, after a solver that has forces of its own (Provot 1995).
void limit_links(const ClothPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    LinkBatch& c = p.links[i];
    Rows8 a = gather(p.delta_position, c.a), b = gather(p.delta_position, c.b);
    const Lanes3 e = load(c.base) + (b.v - a.v);
    const Lanes size = square_root(dot(e, e)), longest = load(c.rest) * all_lanes(p.stretched);
    if (!any(longest < size)) continue;
    const Lanes over = min(allowed(p, c, longest) - size, zero_lanes());
    push_ends(p, c, a, b, e * (over * reciprocal_or_zero(a.w + b.w) * reciprocal_or_zero(size)));
  }
}

// Ties: projection from outside onto the sphere round the anchor (Kim, Chentanez and Mueller-Fischer 2012).
void solve_ties(const ClothPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const TieBatch& c = p.ties[i];
    Rows8 a = gather(p.delta_position, c.a);
    const Lanes3 e = load(c.base) + a.v;
    const Lanes square = dot(e, e), limit = load(c.limit);
    if (!any(square > limit * limit)) continue;
    const Lanes bound = allowed(p, limit, load(c.base) + gather(p.before, c.a).v);
    const Lanes back = select(square > bound * bound, bound / square_root(square) - all_lanes(1), zero_lanes());
    a.v = a.v + e * back;
    scatter(p.delta_position, c.a, a);
  }
}

// atan(q) for q in [0, 1], error below 2e-8 (Abramowitz and Stegun 4.4.49).
[[gnu::always_inline]] inline Lanes arc_tangent(Lanes q) {
  const Lanes s = q * q;
  Lanes r = all_lanes(0.0028662257f);
  r = r * s + all_lanes(-0.0161657367f);
  r = r * s + all_lanes(0.0429096138f);
  r = r * s + all_lanes(-0.0752896400f);
  r = r * s + all_lanes(0.1065626393f);
  r = r * s + all_lanes(-0.1420889944f);
  r = r * s + all_lanes(0.1999355085f);
  r = r * s + all_lanes(-0.3333314528f);
  return q + q * s * r;
}

struct HingeRows {
  Rows8 v[4];
  Lanes3 e[3];  // edges now, from v[0]
};

[[gnu::always_inline]] inline HingeRows gather_hinge(const ClothPass& p, const HingeBatch& c) {
  HingeRows r;
  for (int k = 0; k < 4; ++k) r.v[k] = gather(p.delta_position, c.v[k]);
  for (int k = 0; k < 3; ++k) r.e[k] = load(c.base[k]) + (r.v[k + 1].v - r.v[0].v);
  return r;
}

struct HingeShape {
  Lanes3 gradient[4];
  Lanes sine, cosine;  // of the angle, not normalised
  Lanes weight;        // sum of w |gradient|^2
};

[[gnu::always_inline]] inline HingeShape hinge_shape(const HingeRows& r) {
  HingeShape s;
  const Lanes3 &e = r.e[0], &a = r.e[1], &b = r.e[2];
  const Lanes3 n1 = cross(e, a), n2 = cross(b, e);
  const Lanes e2 = dot(e, e), size = square_root(e2), inv_e = reciprocal_or_zero(size);
  s.sine = dot(cross(n1, n2), e) * inv_e;
  s.cosine = dot(n1, n2);
  // dihedral gradients (Bridson 2003): v[2] or v[3] moving along its triangle's normal closes the angle at 1/height
  s.gradient[2] = n1 * (zero_lanes() - size * reciprocal_or_zero(dot(n1, n1)));
  s.gradient[3] = n2 * (zero_lanes() - size * reciprocal_or_zero(dot(n2, n2)));
  const Lanes inv_e2 = inv_e * inv_e;
  s.gradient[1] = (s.gradient[2] * dot(a, e) + s.gradient[3] * dot(b, e)) * (zero_lanes() - inv_e2);
  const Lanes3 sum = s.gradient[1] + s.gradient[2] + s.gradient[3];
  s.gradient[0] = sum * all_lanes(-1);
  s.weight = zero_lanes();
  for (int k = 0; k < 4; ++k) s.weight += r.v[k].w * dot(s.gradient[k], s.gradient[k]);
  return s;
}

// Angle of a sine and cosine (times any length) less that of the unit c0, s0, in (-pi, pi): twice the arc tangent of
// sine/(1 + cosine).
[[gnu::always_inline]] inline Lanes angle_between(Lanes sine_now, Lanes cosine_now, Lanes c0, Lanes s0) {
  const Lanes zero = zero_lanes();
  const Lanes sine = sine_now * c0 - cosine_now * s0, cosine = cosine_now * c0 + sine_now * s0;
  const Lanes up = select(sine < zero, zero - sine, sine);
  const Lanes along = square_root(sine * sine + cosine * cosine) + cosine;
  const LaneMask steep = up > along;
  const Lanes low = select(steep, along, up), high = select(steep, up, along);
  const Lanes half = arc_tangent(low * reciprocal_or_zero(high));
  const Lanes angle = all_lanes(2) * select(steep, all_lanes(1.57079632679489662f) - half, half);
  return select(sine < zero, zero - angle, angle);
}

// Angle relative to rest.
[[gnu::always_inline]] inline Lanes bent(const HingeBatch& c, const HingeShape& s) {
  return angle_between(s.sine, s.cosine, load(c.cosine), load(c.sine));
}

void solve_hinges(const ClothPass& p) {
  const Lanes inv_h2 = all_lanes(p.inv_h2), zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    HingeBatch& c = p.hinges[i];
    HingeRows r = gather_hinge(p, c);
    const HingeShape s = hinge_shape(r);
    const Lanes alpha = load(c.compliance) * inv_h2, old = p.again ? load(c.multiplier) : zero;
    const Lanes change = (zero - bent(c, s) - alpha * old) * reciprocal_or_zero(s.weight + alpha);
    store(c.multiplier, old + change);
    for (int k = 0; k < 4; ++k) {
      r.v[k].v = r.v[k].v + s.gradient[k] * (change * r.v[k].w);
      scatter(p.delta_position, c.v[k], r.v[k]);
    }
  }
}

// Bending torque k (angle - rest) as an impulse on velocities, limited to a share of what straightens the hinge: where
// a triangle has become narrow, hinges would overshoot together with their neighbours.
void bend_hinges(const ClothPass& p) {
  const Lanes h = all_lanes(p.h), zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    const HingeBatch& c = p.hinges[i];
    const HingeRows r = gather_hinge(p, c);
    const HingeShape s = hinge_shape(r);
    const Lanes torque = h / load(c.compliance), limit = all_lanes(0.15f) * reciprocal_or_zero(s.weight * h);
    const Lanes impulse = (zero - bent(c, s)) * min(torque, limit);
    for (int k = 0; k < 4; ++k) {
      Rows8 u = gather(p.velocity, c.v[k]);
      u.v = u.v + s.gradient[k] * (impulse * u.w);
      scatter(p.velocity, c.v[k], u);
    }
  }
}

// Force of quadratic bending as an impulse on velocities, row by row.
void bend_flat(const ClothPass& p) {
  const Lanes h = all_lanes(p.h), zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    const BendBlock& b = p.bend_blocks[i];
    const Lanes3 own = gather(p.delta_position, b.vertex).v;
    Lanes3 sum{zero, zero, zero};
    for (unsigned e = b.first; e < b.last; ++e) {
      const BendEntry& k = p.bend_entries[e];
      sum = sum + (gather(p.delta_position, k.other).v - own) * load(k.stiffness);
    }
    Rows8 u = gather(p.velocity, b.vertex);
    u.v = u.v + (load(b.force) - sum) * (h * u.w);
    scatter(p.velocity, b.vertex, u);
  }
}

// Damping of strain rate on velocities, implicit in its own row: J = -rate T/(compliance + T weight), T = damping x h.
void damp_links(const ClothPass& p) {
  const Lanes time = all_lanes(p.damping_time);
  for (unsigned i = p.first; i < p.last; ++i) {
    const LinkBatch& c = p.links[i];
    const Rows8 xa = gather(p.delta_position, c.a), xb = gather(p.delta_position, c.b);
    Rows8 a = gather(p.velocity, c.a), b = gather(p.velocity, c.b);
    Lanes3 e = load(c.base) + (xb.v - xa.v);
    e = e * reciprocal_or_zero(square_root(dot(e, e)));
    const Lanes rate = dot(b.v - a.v, e);
    const Lanes impulse = (zero_lanes() - rate) * time * reciprocal_or_zero(load(c.compliance) + time * (a.w + b.w));
    a.v = a.v - e * (impulse * a.w);
    b.v = b.v + e * (impulse * b.w);
    scatter(p.velocity, c.a, a);
    scatter(p.velocity, c.b, b);
  }
}

void damp_hinges(const ClothPass& p) {
  const Lanes time = all_lanes(p.damping_time);
  for (unsigned i = p.first; i < p.last; ++i) {
    const HingeBatch& c = p.hinges[i];
    const HingeRows r = gather_hinge(p, c);
    const HingeShape s = hinge_shape(r);
    Rows8 u[4];
    Lanes rate = zero_lanes();
    for (int k = 0; k < 4; ++k) {
      u[k] = gather(p.velocity, c.v[k]);
      rate += dot(s.gradient[k], u[k].v);
    }
    const Lanes impulse = (zero_lanes() - rate) * time * reciprocal_or_zero(load(c.compliance) + time * s.weight);
    for (int k = 0; k < 4; ++k) {
      u[k].v = u[k].v + s.gradient[k] * (impulse * u[k].w);
      scatter(p.velocity, c.v[k], u[k]);
    }
  }
}

// Gradients and factors for the stages. The response of a triangle that has become narrow is limited to that at rest.
void damp_begin(const ClothPass& p) {
  const Lanes time = all_lanes(p.damping_time);
  for (unsigned i = p.first; i < p.last; ++i) {
    const HingeBatch& c = p.hinges[i];
    const HingeShape s = hinge_shape(gather_hinge(p, c));
    HingeDamping& d = p.damping[i];
    for (int k = 0; k < 4; ++k) store(d.gradient[k], s.gradient[k]);
    const Lanes whole = time / load(c.compliance), limit = load(d.max_response) * time;
    store(d.factor, select(whole * s.weight > limit, limit * reciprocal_or_zero(s.weight), whole));
  }
}

// Damping impulses of all hinges against `rates`, summed in `pushes` (Jacobi).
void damp_stage(const ClothPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const HingeBatch& c = p.hinges[i];
    const HingeDamping& d = p.damping[i];
    Lanes3 gradient[4];
    Lanes rate = zero_lanes();
    for (int k = 0; k < 4; ++k) {
      gradient[k] = load(d.gradient[k]);
      rate += dot(gradient[k], gather(p.rates, c.v[k]).v);
    }
    const Lanes impulse = (zero_lanes() - rate) * load(d.factor);
    for (int k = 0; k < 4; ++k) {
      Rows8 push = gather(p.pushes, c.v[k]);
      push.v = push.v + gradient[k] * impulse;
      scatter(p.pushes, c.v[k], push);
    }
  }
}

// still_air() of forces/area.h, and a third of it for each corner. Triangles of pinned corners alone have none.
void meet_still_air(AirPass& p) {
  const Lanes zero = zero_lanes(), third = all_lanes(WideReal(1) / 3);
  Lanes taken = zero;
  for (unsigned i = p.first; i < p.last; ++i) {
    const AirBatch& b = p.batches[i];
    Rows8 x[3], u[3];
    Lanes weight = zero;
    for (int k = 0; k < 3; ++k) {
      x[k] = gather(p.position, b.v[k]), u[k] = gather(p.velocity, b.v[k]);
      weight = max(weight, gather(p.weights, b.v[k]).w);
    }
    const Lanes3 mean = (u[0].v + u[1].v + u[2].v) * third, twice = cross(x[1].v - x[0].v, x[2].v - x[0].v);
    const Lanes speed2 = dot(mean, mean), area2 = dot(twice, twice), through = dot(mean, twice), both = speed2 * area2;
    const LaneMask normal = (both >= all_lanes(p.least)) & (both <= all_lanes(p.largest)) & (weight > zero);
    const Lanes safe = select(normal, both, all_lanes(1));
    const Lanes most = all_lanes(p.most) / select(normal, weight, all_lanes(1));
    const Lanes asked = all_lanes(0.25f * p.density) * square_root(safe);
    taken = max(taken, select(normal, asked / most, zero));
    const Lanes square = through * through / safe;
    const Lanes along = all_lanes(p.drag) * (square + all_lanes(p.skin)) - all_lanes(p.lift) * square;
    const Lanes rate = select(normal, min(asked, most) * third, zero);
    Rows8 push;
    push.v =
        (mean * along + twice * (all_lanes(p.lift) * through / select(normal, area2, all_lanes(1)))) * (zero - rate);
    push.w = zero;
    unsigned at[kLanes];
    for (int k = 0; k < kLanes; ++k) at[k] = i * kLanes + static_cast<unsigned>(k);
    scatter(p.push, at, push);
  }
  p.taken = 0;
  for (int k = 0; k < kLanes; ++k) p.taken = p.taken > taken[k] ? p.taken : taken[k];
}

constexpr ClothKernels kKernels = {solve_links<false>,
                                   solve_links<true>,
                                   solve_links<false, true>,
                                   solve_links<true, true>,
                                   limit_links,
                                   solve_ties,
                                   solve_hinges,
                                   bend_hinges,
                                   bend_flat,
                                   damp_links,
                                   damp_hinges,
                                   damp_begin,
                                   damp_stage,
                                   meet_still_air};

}  // namespace
}  // namespace feder
