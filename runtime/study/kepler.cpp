// A body around a fixed centre, GM = a = 1, from the pericentre. Reference: Kepler's equation
// E - e sin E = t by Newton in long double. The start decides much: from the pericentre, kicks first and drifts first
// differ by an order of magnitude.
// Source: Kepler 1609. Does not show: damping, or stiffness other than by the eccentricity.
#include "study/ode.h"

namespace feder {
namespace {

class Equation final : public PointEquation {
 public:
  explicit Equation(double pericentre) { rate = std::sqrt(2) * std::pow(pericentre, -1.5); }
  Vec3 force(const Vec3& x, const Vec3&, double) const override {
    const Real r2 = dot(x, x);
    return x * (-1 / (r2 * std::sqrt(r2)));
  }
  Mat3 stiffness(const Vec3& x, const Vec3&, double) const override {
    const Real r = length(x), r3 = r * r * r;
    const Vec3 n = x / r;
    Mat3 k = n * (3 * n.transpose());
    k.diagonal().array() -= 1;
    return Mat3(k / r3);
  }
  Invariants invariants(const Vec3& x, const Vec3& v) const override {
    const double a[3] = {x[0], x[1], x[2]}, b[3] = {v[0], v[1], v[2]};
    const double r = std::hypot(a[0], a[1], a[2]), speed = std::hypot(b[0], b[1], b[2]);
    Invariants i;
    i.energy = 0.5 * speed * speed - 1 / r;
    for (int k = 0; k < 3; ++k) i.angular[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    i.angular_scale = r * speed;
    return i;
  }
};

class Kepler final : public OdeProblem {
 public:
  explicit Kepler(const Params& given) {
    ProblemOptions o(given, info_);
    e_ = o.number("e", 0.6, 0, 0.999, "eccentricity");
    const double periods = o.number("periods", 1, 1e-3, 1e5, "length of the run; a period is 2 pi seconds");
    info_.t_end = periods * 6.283185307179586477;
    info_.dof = 2;
    info_.v_scale = std::sqrt((1 + e_) / (1 - e_));
    info_.energy_start = -0.5;
    info_.energy_scale = std::max(0.5, 0.5 * info_.v_scale * info_.v_scale);
    info_.conserves_angular = true;
    equation_ = std::make_unique<Equation>(1 - e_);
    info_.frequency = equation_->rate;
    x0_ = Vec3(static_cast<Real>(1 - e_), 0, 0);
    v0_ = Vec3(0, static_cast<Real>(info_.v_scale), 0);
    // an error of the start's size grows with the passed periods: the period changes
    set_reference(ReferenceKind::closed, 15, 1e-15 * (1 + periods), "Kepler's equation in long double");
    steps_ = doubling(std::max(1, static_cast<int>(50 * periods)), periods > 20 ? 8 : 12);
    tolerance_steps_ = std::max(16, static_cast<int>(8 * periods));
  }

  void reference(double t, Observation& out) const override {
    const Wide e = e_, mean = std::remainder(static_cast<Wide>(t), 6.28318530717958647692528676655900577L);
    Wide anomaly = mean < 0 ? mean - e : mean + e;  // on the far side, from where Newton converges
    for (int k = 0; k < 100; ++k) {
      const Wide step = (anomaly - e * std::sin(anomaly) - mean) / (1 - e * std::cos(anomaly));
      anomaly -= step;
      if (std::fabs(step) < 1e-19L) break;
    }
    const Wide c = std::cos(anomaly), s = std::sin(anomaly), b = std::sqrt(1 - e * e), rate = 1 / (1 - e * c);
    out = {{static_cast<double>(c - e), static_cast<double>(b * s), 0},
           {static_cast<double>(-s * rate), static_cast<double>(b * c * rate), 0},
           {}};
  }

 private:
  double e_;
};

}  // namespace

Variant<StudyProblem> study_kepler() {
  return variant_of<StudyProblem, Kepler>(
      "kepler", "orbit around a fixed centre from the pericentre; e = 0.9 asks for steps that adapt");
}

}  // namespace feder
