// Two unit masses on two unit rods, g = 9.81, from rest with both rods level. The angles from the
// vertical are the coordinates; the mass matrix is solved within the force, which so depends on velocity without
// damping anything. Chaotic: beyond t = 3 what counts is how long a run stays with the reference.
// Reference: Gragg-Bulirsch-Stoer extrapolation (reference.h). Does not show: order beyond that time.
#include "study/ode.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81;

// theta1'' (2 - c^2) = ..., with c and s of theta1 - theta2
template <class T>
void accelerations(T wa, T wb, T sa, T sb, T s, T c, T& da, T& db) {
  const T g = static_cast<T>(kGravity);
  const T p = -s * wb * wb - 2 * g * sa, q = s * wa * wa - g * sb;
  const T det = 2 - c * c;
  da = (p - c * q) / det;
  db = (2 * q - c * p) / det;
}

class Equation final : public PointEquation {
 public:
  Equation() {
    rate = 8;
    damped = true;
  }
  Vec3 force(const Vec3& x, const Vec3& v, double) const override {
    Real sa, ca, sb, cb, s, c, da, db;
    sin_cos(x[0], sa, ca), sin_cos(x[1], sb, cb), sin_cos(x[0] - x[1], s, c);
    accelerations(v[0], v[1], sa, sb, s, c, da, db);
    return Vec3(da, db, 0);
  }
  Mat3 stiffness(const Vec3& x, const Vec3& v, double) const override { return difference(x, v, true); }
  Mat3 damping(const Vec3& x, const Vec3& v, double) const override { return difference(x, v, false); }
  Invariants invariants(const Vec3& x, const Vec3& v) const override {
    const double a = x[0], b = x[1], wa = v[0], wb = v[1];
    Invariants i;
    i.energy = wa * wa + 0.5 * wb * wb + wa * wb * std::cos(a - b) - kGravity * (2 * std::cos(a) + std::cos(b));
    return i;
  }

 private:
  Mat3 difference(const Vec3& x, const Vec3& v, bool by_position) const {
    Mat3 out = Mat3::Zero();
    const Real d = std::cbrt(kEpsilon);
    for (int k = 0; k < 2; ++k) {
      Vec3 up = Vec3::Zero();
      up[k] = d;
      const Vec3 none = Vec3::Zero();
      const Vec3& dx = by_position ? up : none;
      const Vec3& dv = by_position ? none : up;
      out.col(k) = (force(x + dx, v + dv, 0) - force(x - dx, v - dv, 0)) / (2 * d);
    }
    return out;
  }
};

class DoublePendulum final : public OdeProblem {
 public:
  explicit DoublePendulum(const Params& given) {
    ProblemOptions o(given, info_);
    info_.t_end = o.number("t_end", 3, 0.01, 50, "s; above 3 the horizon of the error is what counts");
    info_.chaotic = info_.t_end > 3;
    info_.dof = 2;
    info_.v_scale = 6;
    info_.energy_start = 0;
    info_.energy_scale = 3 * kGravity;  // what the fall to the bottom sets free
    info_.frequency = 8;
    equation_ = std::make_unique<Equation>();
    x0_ = Vec3(kPi / 2, kPi / 2, 0);
    // errors grow by about e^(2.5 t)
    const double growth = std::exp(2.5 * info_.t_end);
    set_reference(ReferenceKind::quad, 15, 1e-17 * growth, "extrapolation of order 20 in long double");
    info_.reference.rounding = static_cast<double>(kEpsilon) / 2 * growth;
    steps_ = doubling(30, 12);
    const double level = 1.5707963267948966;
    use_extrapolation(
        [](Wide, const Wide* y, Wide* d) {
          d[0] = y[2], d[1] = y[3];
          accelerations<Wide>(y[2], y[3], std::sin(y[0]), std::sin(y[1]), std::sin(y[0] - y[1]), std::cos(y[0] - y[1]),
                              d[2], d[3]);
        },
        {level, level, 0, 0});
  }
};

}  // namespace

Variant<StudyProblem> study_double_pendulum() {
  return variant_of<StudyProblem, DoublePendulum>("double_pendulum",
                                                  "two rods from the level; chaotic after a few seconds");
}

}  // namespace feder
