// A velocity kick v += h f/m whose velocity-dependent part is taken at the new velocity:
//   (M - h D) dv = h f(x, v),  D = df/dv at (x, v).
// Shared by the methods that treat damping implicitly; without damping it is the plain kick and solves nothing.
#pragma once
#include "integrate/integrator.h"
#include "linear/cg.h"

namespace feder {

class DampedKick {
 public:
  DampedKick(Arena& a, bool implicit) : implicit_(implicit), force_(&a), d_(a), dv_(&a), cg_(a) {}

  // One force evaluation, at (x, v, t).
  void apply(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v, IntegratorStats& stats);

 private:
  void solve(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v, IntegratorStats& stats);

  bool implicit_;
  Array<Vec3> force_;
  BlockSparse d_;
  Array<Vec3> dv_;
  ConjugateGradient cg_;
  std::vector<BlockIndex> pattern_;
  std::uint64_t pattern_version_ = ~std::uint64_t{0};
};

}  // namespace feder
