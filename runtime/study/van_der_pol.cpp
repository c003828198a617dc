// x'' = mu (1 - x^2) x' - x from (2, 0) (van der Pol 1926). Stiff while it creeps, fast while it jumps; no energy.
// Does not show: energy errors; explicit methods only as failing.
#include "study/ode.h"

namespace feder {
namespace {

class Equation final : public PointEquation {
 public:
  explicit Equation(double mu) : mu_(static_cast<Real>(mu)) {
    damped = true;
    rate = std::sqrt(1 + 12 * mu);
    decay = 3.1 * mu;
  }
  Vec3 force(const Vec3& x, const Vec3& v, double) const override {
    return Vec3(mu_ * (1 - x[0] * x[0]) * v[0] - x[0], 0, 0);
  }
  Mat3 stiffness(const Vec3& x, const Vec3& v, double) const override { return along_x(-2 * mu_ * x[0] * v[0] - 1); }
  Mat3 damping(const Vec3& x, const Vec3&, double) const override { return along_x(mu_ * (1 - x[0] * x[0])); }

 private:
  Real mu_;
};

class VanDerPol final : public OdeProblem {
 public:
  explicit VanDerPol(const Params& given) {
    ProblemOptions o(given, info_);
    mu_ = o.number("mu", 1000, 0.1, 1e4, "stiffness; the period is about 1.6 mu");
    info_.t_end = o.number("t_end", 2 * mu_, 1e-3, 1e5, "s");
    info_.x_scale = 2;
    info_.v_scale = 1.5 * mu_;  // during the jumps
    info_.frequency = 3 * mu_;
    equation_ = std::make_unique<Equation>(mu_);
    x0_ = Vec3(2, 0, 0);
    set_reference(ReferenceKind::quad, 13, 1e-14,
                  "extrapolation of order 20 in long double; agrees with the IVP Test Set");
    // creeping solutions attract each other: no rounding grows
    info_.reference.rounding = static_cast<double>(kEpsilon);
    use_extrapolation(
        [mu = static_cast<Wide>(mu_)](Wide, const Wide* y, Wide* d) {
          d[0] = y[1];
          d[1] = mu * (1 - y[0] * y[0]) * y[1] - y[0];
        },
        {2, 0});
  }

  std::vector<RunSpec> ladder(const MethodInfo& m) const override {
    if (m.adaptive) return OdeProblem::ladder(m);
    // explicit ones need h < 2/(3 mu): one rung shows them fail
    const double limit = info_.t_end * 3 * mu_ / 2;
    std::vector<RunSpec> rungs;
    if (m.implicit) {
      for (double steps = info_.t_end; steps < 300 * info_.t_end; steps *= 2)
        rungs.push_back({m.name, static_cast<int>(steps), 0, 0, 0, {}});
    } else {
      for (const double part : {0.1, 1.2, 2.4}) rungs.push_back({m.name, static_cast<int>(part * limit), 0, 0, 0, {}});
    }
    return rungs;
  }

 private:
  double mu_;
};

}  // namespace

Variant<StudyProblem> study_van_der_pol() {
  return variant_of<StudyProblem, VanDerPol>("van_der_pol", "stiff relaxation oscillations: creeps and jumps");
}

}  // namespace feder
