// y' = lambda (y - cos t) - sin t, y(0) = 1, exact cos t, lambda = -1e6 (Prothero and Robinson 1974). Shows order
// reduction: stiff beyond all steps, though the solution is smooth. Of the first order: y is the velocity of a point
// whose position nobody asks for, so what is observed is v.
// Does not show: anything of positions.
#include "study/ode.h"

namespace feder {
namespace {

class Equation final : public PointEquation {
 public:
  explicit Equation(double lambda) : lambda_(static_cast<Real>(lambda)) {
    damped = true;
    decay = lambda;
  }
  Vec3 force(const Vec3&, const Vec3& v, double t) const override {
    const Real c = static_cast<Real>(sin_cos_cos(t)), s = static_cast<Real>(sin_cos_sin(t));
    return Vec3(-lambda_ * (v[0] - c) - s, 0, 0);
  }
  Mat3 damping(const Vec3&, const Vec3&, double) const override { return along_x(-lambda_); }
  void observe(const Vec3&, const Vec3& v, double, Observation& out) const override { out = {{v[0], 0, 0}, {}, {}}; }

 private:
  Real lambda_;
};

class ProtheroRobinson final : public OdeProblem {
 public:
  explicit ProtheroRobinson(const Params& given) {
    ProblemOptions o(given, info_);
    const double lambda = o.number("lambda", 1e6, 1, 1e12, "rate of the attraction, 1/s");
    info_.t_end = o.number("t_end", 10, 1e-3, 1e4, "s");
    info_.frequency = lambda;
    info_.dense = false;
    equation_ = std::make_unique<Equation>(lambda);
    v0_ = Vec3(1, 0, 0);
    set_reference(ReferenceKind::closed, 16, 2e-16, "cos t");
    steps_ = doubling(25, 9);
  }
  void reference(double t, Observation& out) const override { out = {{std::cos(t), 0, 0}, {}, {}}; }
};

}  // namespace

Variant<StudyProblem> study_prothero_robinson() {
  return variant_of<StudyProblem, ProtheroRobinson>(
      "prothero_robinson", "a smooth solution that attracts at the rate 1e6: order reduction of stiff methods");
}

}  // namespace feder
