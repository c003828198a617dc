// Stability limits by the conditions of Jury (1962) on the matrix of one step, scanned and bisected. Weak spot: the
// scan takes steps of 2 %, so a narrower unstable band is passed over.
#include "integrate/limits.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace feder {
namespace {

// Of determinant and trace; exact flows know their phase z to a rounding of z.
constexpr double rounding(double z) { return 16 * (1 + z) * static_cast<double>(kEpsilon); }
constexpr int kSamples = sizeof(Real) == 4 ? 4000 : 4;
constexpr int kRunSteps = 500;
constexpr double kFirst = 1e-3, kLast = 1e6;
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// |P(z lambda)| - 1 of the faster root lambda = -zeta +- sqrt(zeta^2 - 1).
double polynomial_excess(std::span<const double> p, double z, double zeta) {
  double worst = -1;
  for (const double side : {-1.0, 1.0}) {
    const std::complex<double> root = std::sqrt(std::complex<double>(zeta * zeta - 1, 0));
    const std::complex<double> at = z * (-zeta + side * root);
    std::complex<double> sum = 0;
    for (std::size_t k = p.size(); k-- > 0;) sum = sum * at + p[k];
    worst = std::max(worst, std::abs(sum) - 1);
  }
  return worst;
}

// Smallest z with excess(z) > 0, by scan and bisection.
template <class F>
double first_positive(F&& excess) {
  double below = 0;
  for (double z = kFirst; z <= kLast; below = z, z *= 1.02) {
    if (!(excess(z) > 0)) continue;
    double above = z;
    for (int k = 0; k < 80; ++k) {
      const double middle = (below + above) / 2;
      (excess(middle) > 0 ? above : below) = middle;
    }
    return above;
  }
  return std::numeric_limits<double>::infinity();
}

// Growth of a long run: for methods that remember.
double run_excess(const Variant<Integrator>& method, const Params& options, double z, double zeta) {
  Arena arena("limits");
  const auto m = method.make(arena, options);
  Oscillator field(1, zeta);
  Vec3 x(1, 1, 1), v(0, 0, 0);
  for (int k = 0; k < kRunSteps; ++k) {
    m->step(field, 0, static_cast<Real>(z), {&x, 1}, {&v, 1});
    if (!(length(x) < 1e4) || !(length(v) < 1e4)) return 1;
  }
  return -1;
}

// One point under g = 1.
class Falling final : public ForceField {
 public:
  std::size_t count() const override { return 1; }
  std::span<const Real> inv_mass() const override { return {&one_, 1}; }
  std::span<const Real> mass() const override { return {&one_, 1}; }
  void eval(std::span<const Vec3>, std::span<const Vec3>, double, std::span<Vec3> force) override {
    force[0] = Vec3(1, 0, 0);
  }
  bool damped() const override { return false; }
  bool stiff_damping(Real) const override { return false; }
  void damping(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& d) override { d.set_zero(); }
  void jacobian(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& k, BlockSparse& d) override {
    k.set_zero(), d.set_zero();
  }
  void pattern(std::vector<BlockIndex>&) const override {}
  std::uint64_t pattern_version() const override { return 1; }

 private:
  Real one_ = 1;
};

}  // namespace

Oscillator::Oscillator(double frequency, double damping_ratio)
    : stiffness_(frequency * frequency), damping_(2 * damping_ratio * frequency) {}

void Oscillator::eval(std::span<const Vec3> x, std::span<const Vec3> v, double, std::span<Vec3> force) {
  force[0] = Vec3d(-stiffness_ * x[0].cast<double>() - damping_ * v[0].cast<double>()).cast<Real>();
}

void Oscillator::damping(std::span<const Vec3>, std::span<const Vec3>, double, BlockSparse& d) {
  d.diagonal[0] = Mat3d::Identity() * -damping_;
}

void Oscillator::jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) {
  damping(x, v, t, d);
  k.diagonal[0] = Mat3d::Identity() * -stiffness_;
}

double StepMatrix::spectral_radius() const {
  const double half = trace() / 2, d = half * half - determinant();
  return d < 0 ? std::sqrt(determinant()) : std::fabs(half) + std::sqrt(d);
}

double StepMatrix::condition(int k) const {
  const double det = determinant();
  const double e = k == 0 ? std::fabs(det) - 1 : (k == 1 ? trace() : -trace()) - 1 - det;
  return std::isfinite(e) ? e : std::numeric_limits<double>::infinity();
}

int StepMatrix::worst_condition() const {
  const double a = condition(0), b = condition(1), c = condition(2);
  return a >= b && a >= c ? 0 : b >= c ? 1 : 2;
}

// Of columns (1, 0) and (0, 1), scaled by `samples` factors from 1 to 2 in each of three directions: the mean is that
// many times less rounded than one step of a float build.
StepMatrix step_matrix(Integrator& method, double z, double zeta, int samples) {
  Oscillator field(1, zeta);
  double out[2][2] = {};
  for (int column = 0; column < 2; ++column)
    for (int k = 0; k < samples; ++k) {
      Vec3 unit;
      for (int axis = 0; axis < 3; ++axis)
        unit[axis] = static_cast<Real>(1 + std::fmod(0.6180339887498949 * (3 * k + axis), 1.0));  // golden ratio: even
      if (samples == 1) unit = Vec3(1, 1, 1);
      Vec3 x = column == 0 ? unit : Vec3(0, 0, 0), v = column == 1 ? unit : Vec3(0, 0, 0);
      method.step(field, 0, static_cast<Real>(z), {&x, 1}, {&v, 1});
      for (int axis = 0; axis < 3; ++axis) {
        out[0][column] += static_cast<double>(x[axis]) / static_cast<double>(unit[axis]) / (3.0 * samples);
        out[1][column] += static_cast<double>(v[axis]) / static_cast<double>(unit[axis]) / (3.0 * samples);
      }
    }
  return {out[0][0], out[0][1], out[1][0], out[1][1]};
}

double predicted_limit(const IntegratorInfo& info, double zeta) {
  if (zeta == 0) return info.stability_limit;
  if (info.damped_limit) return info.damped_limit(zeta);
  if (info.stability_polynomial.empty()) return kNothing;
  return first_positive([&](double z) { return polynomial_excess(info.stability_polynomial, z, zeta) - 1e-15; });
}

double observed_limit(const Variant<Integrator>& method, const Params& options, double zeta) {
  Arena arena("limits");
  Params p = options;
  if (method.make(arena, p)->info().adaptive) p.set("adaptive", false);
  const auto m = method.make(arena, p);
  step_matrix(*m, 1, zeta, 1);
  if (!m->memory.points.empty() || !m->memory.numbers.empty())
    return first_positive([&](double z) { return run_excess(method, p, z, zeta); });

  const auto matrix = [&](double z, int samples) {
    return step_matrix(*m, static_cast<double>(static_cast<Real>(z)), zeta, samples);
  };
  const double rough = first_positive([&](double z) { return matrix(z, 1).excess() - rounding(z); });
  if (!std::isfinite(rough)) return rough;
  // which of the three conditions fails there, and where below does it hold for certain?
  const int which = matrix(rough * 1.001, kSamples).worst_condition();
  double below = rough, above = rough * 1.01;
  while (!(matrix(below, 1).condition(which) < -rounding(below) / 2)) {
    below *= 0.99;
    if (below < kFirst) return 0;  // nowhere: the growth falls with a power of z down to rounding
  }
  while (above - below > static_cast<double>(kEpsilon) / 2 * above) {
    const double middle = (below + above) / 2;
    if (!(middle > below && middle < above)) break;  // neighbours
    (matrix(middle, kSamples).condition(which) > 0 ? above : below) = middle;
  }
  return (below + above) / 2;
}

// Between the fourth and the eighth step, so that no start-up counts; in quarters: the rest is rounding.
Real free_fall_lead(Integrator& method) {
  Falling field;
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
  Real at_four = 0;
  for (int k = 0; k < 8; ++k) {
    method.step(field, k, 1, {&x, 1}, {&v, 1});
    if (k == 3) at_four = x[0];
  }
  return std::round((x[0] - at_four - Real(0.5 * (64 - 16))) / 4 * 4) / 4;
}

}  // namespace feder
