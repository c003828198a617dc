// A velocity kick v += h f/m whose velocity-dependent part may be taken at v + share dv, share = 1 the new velocity:
//   (M - share h D) dv = h f(x, v),  D = df/dv at (x, v).
// The solve costs tens of plain kicks, so it is done only where damping is stiff.
#pragma once
#include "integrate/pattern.h"
#include "linear/cg.h"

namespace feder {

class DampedKick {
 public:
  explicit DampedKick(Arena& a) : force_(&a), start_(&a), d_(a), dv_(&a), cg_(a) {}

  // One force evaluation, at (x, v, t).
  void apply(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v, IntegratorStats& stats);
  // The same with the damping at v + share dv.
  void apply_implicit(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x, std::span<Vec3> v,
                      IntegratorStats& stats);
  // To second order: plain without damping, implicit where it is stiff, corrected where it is weak.
  void apply_second_order(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x, std::span<Vec3> v,
                          IntegratorStats& stats);

 private:
  // A plain kick gives the velocity at which the damping is evaluated again.
  void apply_corrected(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x, std::span<Vec3> v,
                       IntegratorStats& stats);

  Array<Vec3> force_, start_;
  BlockSparse d_;
  Array<Vec3> dv_;
  ConjugateGradient cg_;
  FieldPattern pattern_;
};

}  // namespace feder
