// What the code of a method does, measured: stability limits on the oscillator x'' = -w^2 x - 2 zeta w x', as the
// product h w = z, beside what the theory of the method says; and its lead in free fall. Limits are read off the matrix
// of one step, which is linear in the state, not off long runs.
#pragma once
#include "integrate/integrator.h"

namespace feder {

// One point of mass 1 on the x axis; y and z hold copies of the same oscillator.
class Oscillator final : public ForceField {
 public:
  Oscillator(double frequency, double damping_ratio);
  std::size_t count() const override { return 1; }
  std::span<const Real> inv_mass() const override { return {&one_, 1}; }
  std::span<const Real> mass() const override { return {&one_, 1}; }
  void eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) override;
  bool damped() const override { return damping_ != 0; }
  bool stiff_damping(Real h) const override {
    const double dt = static_cast<double>(h);
    return dt * dt * stiffness_ + 2 * dt * damping_ > 4;
  }
  void damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) override;
  void jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) override;
  void pattern(std::vector<BlockIndex>&) const override {}
  std::uint64_t pattern_version() const override { return 1; }

 private:
  double stiffness_, damping_;  // N/m, N s/m; not rounded to Real, so that the limits are those of the method
  Real one_ = 1;
};

// (x, v) -> R (x, v), with w = 1 and h = z.
struct StepMatrix {
  double xx = 0, xv = 0, vx = 0, vv = 0;
  double determinant() const { return xx * vv - xv * vx; }
  double trace() const { return xx + vv; }
  double spectral_radius() const;
  // Both eigenvalues are within the unit circle when these are all <= 0 (Jury): |det| - 1, trace - 1 - det,
  // -trace - 1 - det. Not squared or rooted: small rounding stays small.
  double condition(int k) const;
  int worst_condition() const;
  double excess() const { return condition(worst_condition()); }
};

// Stepping scaled unit vectors; `method` must remember nothing (see observed_limit).
StepMatrix step_matrix(Integrator& method, double z, double zeta, int samples = 1);

// Smallest z that is unstable, from info: damped_limit, the stability polynomial, or stability_limit where zeta = 0.
// NaN when info does not tell.
double predicted_limit(const IntegratorInfo& info, double zeta);

// The same from the code of the method: scanned in steps of 2 % up to 1e6 (infinity when stable throughout), then the
// condition that fails is followed to its zero (0 when there is none above rounding). The float build averages the
// matrix over many scaled vectors, else its rounding would decide; coefficients a method rounds to float are part of it
// and stay (runge_kutta.cpp therefore does not). Adaptive methods are asked for single steps (adaptive = false). A
// method with memory is run instead, some hundred steps for each z, and then the value is as sharp as that.
double observed_limit(const Variant<Integrator>& method, const Params& options, double zeta);

// By how many steps the velocity that a method works with leads the true one in free fall, from its code: x after n
// steps h is x0 + v0 n h + g (n h)^2/2 + lead g n h^2.
Real free_fall_lead(Integrator& method);

}  // namespace feder
