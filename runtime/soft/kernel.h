// The arithmetic of tetrahedra, eight at a time. Included by kernel_plain.cpp and kernel_avx2.cpp, which differ in
// compiler flags only and give the same bits.
// Stable neo-Hookean energy (Smith, de Goes and Kim 2018; soft/solver.h) as the two rows of Macklin and Mueller ("A
// Constraint-based Formulation of Stable Neo-Hookean Materials", MIG 2021), with the shear modulus of the logarithm:
//   C_D = |F|, compliance 1/(mu_F V), mu_F = mu' |F|^2/(|F|^2 + 1);   C_H = det F - gamma, compliance 1/(lambda' V).
// Displacements are from the start of the step, as in cloth: what a solver substep adds is far below the rounding of a
// position, but not of a displacement.
#pragma once
#include "base/lane_rows.h"
#include "soft/batch.h"

namespace feder {
namespace {

using namespace lanes;

constexpr WideReal kRootThree = 1.7320508f;

struct TetRows {
  Rows8 x[4];   // displacements
  Lanes3 f[3];  // columns of the deformation gradient F
};

[[gnu::always_inline]] inline void deform(const TetBatch& c, TetRows& r) {
  Lanes3 e[3];
  for (int k = 0; k < 3; ++k) e[k] = load(c.base[k]) + (r.x[k + 1].v - r.x[0].v);
  const Lanes3 a = load(c.gradient[0]), b = load(c.gradient[1]), d = load(c.gradient[2]);
  r.f[0] = e[0] * a.x + e[1] * b.x + e[2] * d.x;
  r.f[1] = e[0] * a.y + e[1] * b.y + e[2] * d.y;
  r.f[2] = e[0] * a.z + e[1] * b.z + e[2] * d.z;
}

[[gnu::always_inline]] inline TetRows gather_tets(const TetPass& p, const TetBatch& c) {
  TetRows r;
  for (int k = 0; k < 4; ++k) r.x[k] = gather(p.delta_position, c.v[k]);
  deform(c, r);
  return r;
}

// Columns of the cofactor matrix: gradient of det F.
[[gnu::always_inline]] inline void cofactors(const Lanes3 (&f)[3], Lanes3 (&g)[3]) {
  g[0] = cross(f[1], f[2]), g[1] = cross(f[2], f[0]), g[2] = cross(f[0], f[1]);
}

[[gnu::always_inline]] inline Lanes squares(const Lanes3 (&f)[3]) {
  return dot(f[0], f[0]) + dot(f[1], f[1]) + dot(f[2], f[2]);
}

// Gradients by point from those by F, given in columns.
[[gnu::always_inline]] inline void by_point(const TetBatch& c, const Lanes3 (&p)[3], Lanes3 (&out)[4]) {
  for (int k = 0; k < 3; ++k) {
    const Lanes3 g = load(c.gradient[k]);
    out[k + 1] = p[0] * g.x + p[1] * g.y + p[2] * g.z;
  }
  out[0] = (out[1] + out[2] + out[3]) * all_lanes(-1);
}

[[gnu::always_inline]] inline Lanes shear_modulus(const TetPass& p, Lanes f_squares) {
  return all_lanes(p.shear) * (f_squares / (f_squares + all_lanes(1)));
}

// Share of the stress that one push carries: the stiffness now, bounded from above, against `carried`. At rest that
// bound is 3 lame + 2 mu; it grows with the squares of areas and where the volume is far from the rest volume.
[[gnu::always_inline]] inline Lanes carried(const TetPass& p, const TetBatch& c, Lanes cofactor_squares, Lanes beyond,
                                            Lanes f_squares) {
  const Lanes zero = zero_lanes(), size = select(beyond < zero, zero - beyond, beyond);
  const Lanes stiffness = max(
      all_lanes(p.lambda) * (cofactor_squares + size * square_root(f_squares)) - all_lanes(p.mu * (0.5f + kRootThree)),
      all_lanes(2 * p.mu));
  const Lanes limit = load(c.room) * all_lanes(p.carried);
  return select(stiffness > limit, limit / stiffness, all_lanes(1));
}

// Both rows push as forces, as an impulse on velocities, at the state that the last solver substep left: exact at rest
// and without loss of energy, momentum or angular momentum, where h times their frequency is small enough. A
// tetrahedron that is strained beyond that pushes by a share.
void push(const TetPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    TetBatch& c = p.tets[i];
    const TetRows r = gather_tets(p, c);
    Lanes3 g[3], stress[3], along[4];
    cofactors(r.f, g);
    const Lanes beyond = dot(r.f[0], g[0]) - all_lanes(p.gamma);
    const Lanes size = squares(r.f), share = carried(p, c, squares(g), beyond, size);
    store(c.share, share);
    p.flagged[i] = any(share < all_lanes(1)) ? 1 : 0;
    const Lanes pressure = all_lanes(p.lambda) * beyond, shear = shear_modulus(p, size);
    for (int k = 0; k < 3; ++k) stress[k] = r.f[k] * shear + g[k] * pressure;
    by_point(c, stress, along);
    const Lanes impulse = (zero_lanes() - load(c.volume)) * share * all_lanes(p.h);
    for (int k = 0; k < 4; ++k) {
      Rows8 u = gather(p.velocity, c.v[k]);
      u.v = u.v + along[k] * (impulse * u.w);
      scatter(p.velocity, c.v[k], u);
    }
  }
}

// One XPBD row: dL = -C/(sum w |grad C|^2 + alpha) with alpha = 1/stiffness, N s^2/m.
[[gnu::always_inline]] inline void solve_row(const TetPass& p, const TetBatch& c, TetRows& r, Lanes value,
                                             const Lanes3 (&gradient)[3], Lanes stiffness) {
  Lanes3 along[4];
  by_point(c, gradient, along);
  Lanes weight = zero_lanes();
  for (int k = 0; k < 4; ++k) weight += r.x[k].w * dot(along[k], along[k]);
  const Lanes change = (zero_lanes() - value) * stiffness / (all_lanes(1) + stiffness * weight);
  for (int k = 0; k < 4; ++k) {
    r.x[k].v = r.x[k].v + along[k] * (change * r.x[k].w);
    scatter(p.delta_position, c.v[k], r.x[k]);
  }
}

// What pushes did not carry, as XPBD rows at the predicted positions: stable for any strain, at a loss of energy.
void remainder(const TetPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    if (!p.flagged[i]) continue;
    const TetBatch& c = p.tets[i];
    TetRows r = gather_tets(p, c);
    const Lanes left = (all_lanes(1) - load(c.share)) * load(c.volume) * all_lanes(p.h * p.h);
    const Lanes square = squares(r.f), size = square_root(square), inv = reciprocal_or_zero(size);
    Lanes3 g[3];
    for (int k = 0; k < 3; ++k) g[k] = r.f[k] * inv;
    solve_row(p, c, r, size, g, left * shear_modulus(p, square));
    deform(c, r);
    cofactors(r.f, g);
    solve_row(p, c, r, dot(r.f[0], g[0]) - all_lanes(p.gamma), g, left * all_lanes(p.lambda));
  }
}

// The deformation and the factor of the stages. The response grows with the largest eigenvalue of A = F^T F, 1 at rest
// and at most m + s sqrt(2) with m = tr A/3, s^2 = tr A^2/3 - m^2 (Wolkowicz and Styan 1980): it is limited to that of
// the stiffest tetrahedron at rest.
void damp_begin(const TetPass& p) {
  for (unsigned i = p.first; i < p.last; ++i) {
    const TetBatch& c = p.tets[i];
    const TetRows r = gather_tets(p, c);
    TetDamping& d = p.damping[i];
    Lanes size = zero_lanes();  // tr A^2
    for (int k = 0; k < 3; ++k) {
      store(d.f[k], r.f[k]);
      for (int j = 0; j < 3; ++j) size += dot(r.f[k], r.f[j]) * dot(r.f[k], r.f[j]);
    }
    const Lanes third = all_lanes(1.0f / 3), mean = squares(r.f) * third;
    const Lanes largest = mean + square_root(max(size * third - mean * mean, zero_lanes()) * all_lanes(2));
    const Lanes scale = min(all_lanes(1), load(c.room) / max(largest, all_lanes(1e-30f)));
    store(d.factor, load(c.volume) * load(c.share) * scale * all_lanes(p.damping_time));
  }
}

// Kelvin-Voigt stress of the rate of Green strain E' = sym(F^T F'), S = 2 mu E' + lame tr(E') 1: impulses against
// `rates`, summed in `pushes` (Jacobi). Symmetric, so momentum and angular momentum are kept; rotation has no rate.
void damp(const TetPass& p) {
  const Lanes two_mu = all_lanes(2 * p.mu), lame = all_lanes(p.lame), half = all_lanes(0.5f);
  for (unsigned i = p.first; i < p.last; ++i) {
    const TetBatch& c = p.tets[i];
    const TetDamping& d = p.damping[i];
    Lanes3 u[3], f[3], rate[3];
    const Lanes3 first = gather(p.rates, c.v[0]).v;
    for (int k = 0; k < 3; ++k) u[k] = gather(p.rates, c.v[k + 1]).v - first, f[k] = load(d.f[k]);
    const Lanes3 g0 = load(c.gradient[0]), g1 = load(c.gradient[1]), g2 = load(c.gradient[2]);
    rate[0] = u[0] * g0.x + u[1] * g1.x + u[2] * g2.x;
    rate[1] = u[0] * g0.y + u[1] * g1.y + u[2] * g2.y;
    rate[2] = u[0] * g0.z + u[1] * g1.z + u[2] * g2.z;
    const Lanes xx = dot(f[0], rate[0]), yy = dot(f[1], rate[1]), zz = dot(f[2], rate[2]);
    const Lanes xy = half * (dot(f[0], rate[1]) + dot(f[1], rate[0]));
    const Lanes yz = half * (dot(f[1], rate[2]) + dot(f[2], rate[1]));
    const Lanes zx = half * (dot(f[2], rate[0]) + dot(f[0], rate[2]));
    const Lanes all = lame * (xx + yy + zz);
    const Lanes3 stress[3] = {f[0] * (two_mu * xx + all) + f[1] * (two_mu * xy) + f[2] * (two_mu * zx),
                              f[0] * (two_mu * xy) + f[1] * (two_mu * yy + all) + f[2] * (two_mu * yz),
                              f[0] * (two_mu * zx) + f[1] * (two_mu * yz) + f[2] * (two_mu * zz + all)};
    Lanes3 along[4];
    by_point(c, stress, along);
    const Lanes factor = zero_lanes() - load(d.factor);
    for (int k = 0; k < 4; ++k) {
      Rows8 to = gather(p.pushes, c.v[k]);
      to.v = to.v + along[k] * factor;
      scatter(p.pushes, c.v[k], to);
    }
  }
}

constexpr TetKernels kTets = {push, remainder, damp_begin, damp};

}  // namespace
}  // namespace feder
