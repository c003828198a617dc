// m x'' = -k x - c x' with m = 1 from (1, 0). Closed form for every damping ratio
//   x = e^(-zeta w0 t) (cos wd t + zeta w0/wd sin wd t), v = -e^(-zeta w0 t) w0^2/wd sin wd t,
// with hyperbolic functions beyond the critical ratio, written with the two real roots because they would overflow.
// Source: Rayleigh, "The Theory of Sound" (1877), III. Does not show: anything of non-linear forces.
#include "study/ode.h"

namespace feder {
namespace {

class Equation final : public PointEquation {
 public:
  Equation(double k, double c) : k_(static_cast<Real>(k)), c_(static_cast<Real>(c)) {
    damped = c > 0;
    rate = std::sqrt(k);
    decay = c;
  }
  Vec3 force(const Vec3& x, const Vec3& v, double) const override { return -k_ * x - c_ * v; }
  Mat3 stiffness(const Vec3&, const Vec3&, double) const override { return Mat3(-k_ * Mat3::Identity()); }
  Mat3 damping(const Vec3&, const Vec3&, double) const override { return Mat3(-c_ * Mat3::Identity()); }
  Invariants invariants(const Vec3& x, const Vec3& v) const override {
    const double p = x[0], s = v[0];
    Invariants i;
    i.energy = 0.5 * (s * s + static_cast<double>(k_) * p * p);
    return i;
  }

 private:
  Real k_, c_;
};

class Oscillator final : public OdeProblem {
 public:
  explicit Oscillator(const Params& given) {
    ProblemOptions o(given, info_);
    k_ = o.number("stiffness", 1, 1e-6, 1e14, "k, N/m; the mass is 1 kg");
    c_ = o.number("damping", 0, 0, 1e9, "c, N s/m; critical is 2 sqrt(k)");
    // long enough for ten radians of the undamped motion, as in the table for k = 1
    info_.t_end = o.number("t_end", k_ <= 1 ? 10 : 1, 1e-6, 1e6, "s");
    const double w = std::sqrt(k_);
    equation_ = std::make_unique<Equation>(k_, c_);
    x0_ = Vec3(1, 0, 0);
    info_.v_scale = std::max(w, 1e-300);
    info_.energy_scale = info_.energy_start = 0.5 * k_;
    info_.frequency = w;
    set_reference(ReferenceKind::closed, 15, 2e-16 * (1 + w * info_.t_end), "closed form");
    // from six steps per period to about 800; stiff ones also far too coarse, where only stability counts
    const double periods = w * info_.t_end / 6.283185307179586;
    const int resolved = std::max(10, static_cast<int>(6 * periods));
    for (int steps = 10; steps < resolved / 3; steps *= 10) steps_.push_back(steps);
    for (const int steps : doubling(resolved, resolved < 1000 ? 10 : 8)) steps_.push_back(steps);
  }

  void reference(double t, Observation& out) const override {
    double x, v;
    damped_oscillation(k_, c_ / 2, t, x, v);
    out = {{x, 0, 0}, {v, 0, 0}, {}};
  }
  double reference_energy(double t) const override {
    double x, v;
    damped_oscillation(k_, c_ / 2, t, x, v);
    return 0.5 * (v * v + k_ * x * x);
  }

 private:
  double k_, c_;
};

}  // namespace

Variant<StudyProblem> study_oscillator() {
  return variant_of<StudyProblem, Oscillator>(
      "oscillator", "mass on a spring with a dashpot, from soft to k = 1e8 and beyond critical damping");
}

}  // namespace feder
