// theta'' = -sin theta (g/L = 1) from rest at theta0; the angle is the coordinate. By elliptic functions
// (Jacobi 1829):
//   sin(theta/2) = k sn(K - t | k), theta' = -2 k cn, with k = sin(theta0/2)
// Does not show: damping; near the top the start alone decides.
#include "study/ode.h"

namespace feder {
namespace {

class Equation final : public PointEquation {
 public:
  Equation() { rate = 1; }
  Vec3 force(const Vec3& x, const Vec3&, double) const override {
    return Vec3(static_cast<Real>(-sin_cos_sin(static_cast<double>(x[0]))), 0, 0);
  }
  Mat3 stiffness(const Vec3& x, const Vec3&, double) const override {
    return along_x(static_cast<Real>(-sin_cos_cos(static_cast<double>(x[0]))));
  }
  Invariants invariants(const Vec3& x, const Vec3& v) const override {
    const double w = v[0], half = std::sin(0.5 * static_cast<double>(x[0]));
    Invariants i;
    i.energy = 0.5 * w * w + 2 * half * half;
    return i;
  }
};

class Pendulum final : public OdeProblem {
 public:
  explicit Pendulum(const Params& given) {
    ProblemOptions o(given, info_);
    const double angle =
        o.number("theta0", 1.5707963267948966, 1e-3, 3.1415, "rad from the vertical, released at rest");
    info_.t_end = o.number("t_end", 10, 1e-3, 1e5, "s, with g/L = 1");
    k_ = std::sin(static_cast<Wide>(angle) / 2);
    k1_ = std::cos(static_cast<Wide>(angle) / 2);
    quarter_ = elliptic_k(k1_ * k1_);
    info_.x_scale = angle;
    info_.v_scale = static_cast<double>(2 * k_);
    info_.energy_start = static_cast<double>(2 * k_ * k_);
    info_.energy_scale = info_.energy_start;
    info_.frequency = 1;
    equation_ = std::make_unique<Equation>();
    x0_ = Vec3(static_cast<Real>(angle), 0, 0);
    // near the top the start is amplified by e^t until the pendulum leaves it
    const double leave = static_cast<double>(quarter_);
    set_reference(ReferenceKind::closed, 15, 1e-16 * (1 + info_.t_end) * std::exp(std::min(leave, info_.t_end)) / 4,
                  "Jacobi elliptic functions in long double");
    info_.reference.rounding *= std::exp(std::min(leave, info_.t_end)) / 4;
    steps_ = doubling(std::max(8, static_cast<int>(info_.t_end)), 11);
  }

  void reference(double t, Observation& out) const override {
    Wide sn, cn, dn;
    jacobi_elliptic(quarter_ - static_cast<Wide>(t), k_ * k_, k1_ * k1_, sn, cn, dn);
    out = {{static_cast<double>(2 * std::atan2(k_ * sn, dn)), 0, 0}, {static_cast<double>(-2 * k_ * cn), 0, 0}, {}};
  }

 private:
  Wide k_, k1_, quarter_;
};

}  // namespace

Variant<StudyProblem> study_pendulum() {
  return variant_of<StudyProblem, Pendulum>("pendulum", "a pendulum of any amplitude, up to nearly upside down");
}

}  // namespace feder
