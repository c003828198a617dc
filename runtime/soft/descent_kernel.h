// Kernels of descent.h; behind kernel.h, whose lanes they use.
#pragma once
#include "soft/descent.h"
#include "soft/kernel.h"

namespace feder {
namespace {

// Sum over the tetrahedra of a point: the force on it, and the Hessian of their energy by its place without what is
// negative of it.
struct PointModel {
  Lanes3 force;
  Lanes xx, yy, zz, xy, xz, yz;
};

[[gnu::always_inline]] inline void add_square(PointModel& m, const Lanes3& a, Lanes s) {
  const Lanes3 b = a * s;
  m.xx += b.x * a.x, m.yy += b.y * a.y, m.zz += b.z * a.z;
  m.xy += b.x * a.y, m.xz += b.x * a.z, m.yz += b.y * a.z;
}

[[gnu::always_inline]] inline Lanes3 combine(const Lanes3 (&columns)[3], const Lanes3& g) {
  return columns[0] * g.x + columns[1] * g.y + columns[2] * g.z;
}

// J is linear in the place of one corner, so the second derivative of the stable neo-Hookean energy by it,
//   mu' (1 - 1/(I + 1)) |g|^2 1 + 2 mu'/(I + 1)^2 (F g)(F g)^T + lambda' (cof F g)(cof F g)^T,  I = |F|^2,
// is never negative.
struct NeoHookean {
  [[gnu::always_inline]] static inline void add(const SoftPointPass& p, const Lanes3 (&f)[3], const Lanes3& g,
                                                Lanes volume, bool hessian, PointModel& m) {
    Lanes3 area[3];
    cofactors(f, area);
    const Lanes one = all_lanes(1), size = squares(f), inv = one / (size + one);
    const Lanes shear = all_lanes(p.shear) * (size * inv) * volume;
    const Lanes pressure = all_lanes(p.lambda) * (dot(f[0], area[0]) - all_lanes(p.gamma)) * volume;
    const Lanes3 along = combine(f, g), across = combine(area, g);
    m.force = m.force - (along * shear + across * pressure);
    if (!hessian) return;
    const Lanes all = shear * dot(g, g);
    m.xx += all, m.yy += all, m.zz += all;
    add_square(m, along, all_lanes(2 * p.shear) * inv * inv * volume);
    add_square(m, across, all_lanes(p.lambda) * volume);
  }
};

// (g S g) 1 + mu (|g|^2 F F^T + (F g)(F g)^T) + lambda (F g)(F g)^T with the stress S = 2 mu E + lambda tr E 1; of the
// first term what is positive.
struct Stvk {
  [[gnu::always_inline]] static inline void add(const SoftPointPass& p, const Lanes3 (&f)[3], const Lanes3& g,
                                                Lanes volume, bool hessian, PointModel& m) {
    const Lanes one = all_lanes(1), half = all_lanes(0.5f);
    const Lanes mu = all_lanes(p.mu) * volume, lame = all_lanes(p.lame) * volume;
    const Lanes ex = dot(f[0], f[0]) - one, ey = dot(f[1], f[1]) - one, ez = dot(f[2], f[2]) - one;  // 2 E
    const Lanes exy = dot(f[0], f[1]), exz = dot(f[0], f[2]), eyz = dot(f[1], f[2]);
    const Lanes all = lame * half * (ex + ey + ez);
    const Lanes3 pull = {mu * (ex * g.x + exy * g.y + exz * g.z) + all * g.x,
                         mu * (exy * g.x + ey * g.y + eyz * g.z) + all * g.y,
                         mu * (exz * g.x + eyz * g.y + ez * g.z) + all * g.z};  // S g
    m.force = m.force - combine(f, pull);
    if (!hessian) return;
    const Lanes tension = max(dot(g, pull), zero_lanes()), square = mu * dot(g, g);
    m.xx += tension, m.yy += tension, m.zz += tension;
    for (int k = 0; k < 3; ++k) add_square(m, f[k], square);
    add_square(m, combine(f, g), mu + lame);
  }
};

template <class Law>
[[gnu::always_inline]] inline void add_tets(const SoftPointPass& p, const SoftPointBatch& b, const WideReal* rows,
                                            const Lanes3& x, bool hessian, PointModel& m) {
  for (unsigned k = b.first; k < b.last; ++k) {
    const SoftPointTet& t = p.tets[k];
    const Lanes zero = zero_lanes();
    Lanes3 f[3] = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}}, own = {zero, zero, zero};
    for (int c = 0; c < 3; ++c) {
      const Lanes3 e = load(t.base[c]) + (gather(rows, t.other[c]).v - x), g = load(t.gradient[c]);
      f[0] = f[0] + e * g.x, f[1] = f[1] + e * g.y, f[2] = f[2] + e * g.z;
      own = own - g;
    }
    Law::add(p, f, own, load(t.volume), hessian, m);
  }
}

// Elastic forces at the start of the solver substep.
template <class Law>
void begin_points(const SoftPointPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const SoftPointBatch& b = p.batches[i];
    PointModel m{};
    add_tets<Law>(p, b, p.before, gather(p.before, b.self).v, false, m);
    scatter(p.force, b.self, {m.force, zero_lanes()});
  }
}

// Each point to the minimum of the quadratic model of its own energy, the others held: H dx = f (Chen et al. 2024, eq.
// 8 and 9), H = m/h^2 + sum over its tetrahedra.
template <class Law>
void descend_points(const SoftPointPass& p) {
  const Lanes zero = zero_lanes();
  for (unsigned i = p.first; i < p.last; ++i) {
    const SoftPointBatch& b = p.batches[i];
    Rows8 x = gather(p.delta_position, b.self);
    const Lanes inertia = load(b.mass) * all_lanes(p.inv_h2);
    PointModel m{};
    m.force = (load(b.goal) - x.v) * inertia;
    m.xx = m.yy = m.zz = inertia;
    add_tets<Law>(p, b, p.delta_position, x.v, true, m);
    // L D L^T; no pivot is below the inertia, which rounding beside a large stiffness would forget
    const LaneMask moves = (x.w > zero) & (inertia > zero);
    const Lanes one = all_lanes(1), floor = select(moves, inertia, one);
    const Lanes i0 = one / max(m.xx, floor), l1 = m.xy * i0, l2 = m.xz * i0;
    const Lanes i1 = one / max(m.yy - l1 * m.xy, floor), e = m.yz - l2 * m.xy, l3 = e * i1;
    const Lanes i2 = one / max(m.zz - l2 * m.xz - l3 * e, floor);
    const Lanes y1 = m.force.y - l1 * m.force.x, y2 = m.force.z - l2 * m.force.x - l3 * y1;
    Lanes3 move;
    move.z = y2 * i2, move.y = y1 * i1 - l3 * move.z, move.x = m.force.x * i0 - l1 * move.y - l2 * move.z;
    const Lanes relaxation = select(moves, all_lanes(p.relaxation), zero);
    move = select(moves, move * relaxation, {zero, zero, zero});
    x.v = x.v + move;
    scatter(p.delta_position, b.self, x);
  }
}

constexpr SoftPointKernels kSoftPoints[kSoftPointLaws] = {
    {"neo_hookean", begin_points<NeoHookean>, descend_points<NeoHookean>},
    {"stvk", begin_points<Stvk>, descend_points<Stvk>}};

}  // namespace
}  // namespace feder
