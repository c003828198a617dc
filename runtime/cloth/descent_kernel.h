// Kernels of descent.h; behind kernel.h, whose lanes they use.
#pragma once
#include "cloth/descent.h"
#include "cloth/kernel.h"

namespace feder {
namespace {

// Elastic forces at the start of the solver substep, of links and of hinges that take part, and strain limits, as
// solve_links has them.
void begin_descent(const DescentPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const DescentBatch& b = p.batches[i];
    const Lanes3 x = gather(p.before, b.self).v;
    Lanes3 force = {zero_lanes(), zero_lanes(), zero_lanes()};
    for (unsigned k = b.first_link; k < b.last_link; ++k) {
      DescentLink& l = p.links[k];
      const Lanes3 e = load(l.base) + (gather(p.before, l.other).v - x);
      const Lanes size = square_root(dot(e, e)), rest = load(l.rest);
      store(l.longest, max(rest * all_lanes(p.stretched), size - all_lanes(p.shed)));
      force = force + e * (load(l.stiffness) * (size - rest) * reciprocal_or_zero(size));
    }
    for (unsigned k = b.first_hinge; k < b.last_hinge && p.hinged; ++k) {
      const DescentHinge& h = p.hinges[k];
      Lane8 angle;
      for (int n = 0; n < kLanes; ++n) angle.v[n] = p.angle[h.hinge[n]];
      force = force - load(h.gradient) * load(angle);
    }
    scatter(p.force, b.self, {force, zero_lanes()});
  }
}

// dihedral.h, eight wide.
[[gnu::always_inline]] inline Lanes angle_of(const DescentBend& b, Lanes3 (&gradient)[4], const WideReal* rows) {
  const Lanes zero = zero_lanes();
  const Lanes3 origin = gather(rows, b.v[0]).v;
  Lanes3 edge[3];
  for (int k = 0; k < 3; ++k) edge[k] = load(b.base[k]) + (gather(rows, b.v[k + 1]).v - origin);
  const Lanes3 &e = edge[0], &x = edge[1], &y = edge[2];
  const Lanes3 n1 = cross(e, x), n2 = cross(y, e);
  const Lanes e2 = dot(e, e), size = square_root(e2);
  const Lanes sine = dot(cross(n1, n2), e) * reciprocal_or_zero(size), cosine = dot(n1, n2);
  const Lanes inv_e2 = reciprocal_or_zero(max(e2, load(b.edge_floor)));
  gradient[2] = n1 * (zero - size * reciprocal_or_zero(max(dot(n1, n1), load(b.area_floor[0]))));
  gradient[3] = n2 * (zero - size * reciprocal_or_zero(max(dot(n2, n2), load(b.area_floor[1]))));
  gradient[1] = (gradient[2] * dot(x, e) + gradient[3] * dot(y, e)) * (zero - inv_e2);
  gradient[0] = (gradient[1] + gradient[2] + gradient[3]) * all_lanes(-1);
  return angle_between(sine, cosine, load(b.cosine), load(b.sine));
}

// Angles and gradients.
void bend_descent(const DescentPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const DescentBend& b = p.bends[i];
    Lanes3 gradient[4];
    const Lanes root = load(b.root);
    Lane8 angle;
    store(angle, angle_of(b, gradient, p.delta_position) * root);
    for (int n = 0; n < kLanes; ++n) p.angle[i * kLanes + static_cast<unsigned>(n)] = angle.v[n];
    for (int k = 0; k < 4; ++k) {
      Lane8x3 g;
      store(g, gradient[k] * root);
      for (int n = 0; n < kLanes; ++n) {
        Lane8x3& to = p.hinges[b.slot[k][n] / kLanes].gradient;
        const unsigned lane = b.slot[k][n] % kLanes;
        to.x.v[lane] = g.x.v[n], to.y.v[lane] = g.y.v[n], to.z.v[lane] = g.z.v[n];
      }
    }
  }
}

// Each vertex to the minimum of the quadratic model of its own energy, the others held: H dx = f (Chen et al. 2024, eq.
// 8 and 9). H = m/h^2 + sum over its links k n n^T + max(tension, 0)/length (1 - n n^T) + sum over its hinges g g^T.
void descend(const DescentPass& p) {
  const Lanes inv_h2 = all_lanes(p.inv_h2), zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    const DescentBatch& b = p.batches[i];
    Rows8 x = gather(p.delta_position, b.self);
    const Lanes inertia = load(b.mass) * inv_h2;
    Lanes3 f = (load(b.goal) - x.v) * inertia;
    Lanes xx = inertia, yy = inertia, zz = inertia, xy = zero, xz = zero, yz = zero;
    for (unsigned k = b.first_link; k < b.last_link; ++k) {
      const DescentLink& l = p.links[k];
      const Lanes3 e = load(l.base) + (gather(p.delta_position, l.other).v - x.v);
      const Lanes size = square_root(dot(e, e)), inv = reciprocal_or_zero(size), pull = load(l.stiffness);
      const Lanes over = size - load(l.longest), limit = pull * all_lanes(p.limit);
      const LaneMask taut = over > zero;
      const Lanes force = pull * (size - load(l.rest)) + select(taut, limit * over, zero);
      const Lanes tension = force * inv;  // over length
      const Lanes across = max(tension, zero), along = (pull + select(taut, limit, zero) - across) * inv * inv;
      f = f + e * tension;
      const Lanes3 s = e * along;
      xx += across + s.x * e.x, yy += across + s.y * e.y, zz += across + s.z * e.z;
      xy += s.x * e.y, xz += s.x * e.z, yz += s.y * e.z;
    }
    const unsigned last_hinge = p.hinged ? b.last_hinge : b.first_hinge;
    for (unsigned k = b.first_hinge; k < last_hinge; ++k) {
      const DescentHinge& h = p.hinges[k];
      const Lanes3 g = load(h.gradient);
      Lane8 angle;
      for (int n = 0; n < kLanes; ++n) angle.v[n] = p.angle[h.hinge[n]];
      f = f - g * load(angle);
      xx += g.x * g.x, yy += g.y * g.y, zz += g.z * g.z;
      xy += g.x * g.y, xz += g.x * g.z, yz += g.y * g.z;
    }
    // L D L^T; no pivot is below the inertia, which rounding beside a large stiffness would forget
    const LaneMask moves = (x.w > zero) & (inertia > zero);
    const Lanes one = all_lanes(1), floor = select(moves, inertia, one);
    const Lanes i0 = one / max(xx, floor), l1 = xy * i0, l2 = xz * i0;
    const Lanes i1 = one / max(yy - l1 * xy, floor), e = yz - l2 * xy, l3 = e * i1;
    const Lanes i2 = one / max(zz - l2 * xz - l3 * e, floor);
    const Lanes y1 = f.y - l1 * f.x, y2 = f.z - l2 * f.x - l3 * y1;
    Lanes3 move;
    move.z = y2 * i2, move.y = y1 * i1 - l3 * move.z, move.x = f.x * i0 - l1 * move.y - l2 * move.z;
    const Lanes relaxation = select(moves, all_lanes(p.relaxation), zero);
    move = select(moves, move * relaxation, {zero, zero, zero});
    x.v = x.v + move;
    scatter(p.delta_position, b.self, x);
    // what that turned its hinges by
    for (unsigned k = b.first_hinge; k < last_hinge; ++k) {
      const DescentHinge& h = p.hinges[k];
      Lane8 turned;
      store(turned, dot(load(h.gradient), move));
      for (int n = 0; n < kLanes; ++n) p.angle[h.hinge[n]] += turned.v[n];
    }
  }
}

constexpr DescentKernels kDescent = {begin_descent, bend_descent, descend};

}  // namespace
}  // namespace feder
