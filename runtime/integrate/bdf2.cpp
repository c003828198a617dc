// BDF2 (Curtiss & Hirschfelder 1952) with the coefficients for a varying step, w = h / h_before:
//   y1 = ((1+w)^2 y0 - w^2 y_before)/(1+2w) + (1+w)/(1+2w) h y1'.
// Order 2, L-stable, one solve a step. The first step is implicit Euler.
// Kept between calls, in `memory`: the displacement of the last step, the velocity before it, the state it left, its h.
// A state that is not the one it left (beyond rounding: couplings hand states through other sums) or another number of
// points starts afresh with implicit Euler, for the whole net: one different coefficient per point would make the
// matrix unsymmetric. So does a step grown beyond w = 2 (zero-stable up to 1 + sqrt 2; smaller ones go on with their
// w). Weak spot: that fresh start; a net in contact or attached to bodies is touched every step and moves by implicit
// Euler.
#include <algorithm>
#include <cmath>

#include "integrate/implicit_solve.h"

namespace feder {
namespace {

constexpr double kMaxGrowth = 2;             // of the step
constexpr Real kSame = Real(16) * kEpsilon;  // of the largest coordinate or velocity

// Is `a` what was left in `b`, to rounding?
bool same(std::span<const Vec3> a, std::span<const Vec3> b) {
  Real size = 0, change = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max(size, b[i].cwiseAbs().maxCoeff());
    const Real difference = (a[i] - b[i]).cwiseAbs().maxCoeff();
    if (!(difference <= change)) change = difference;  // NaN is a change
  }
  return change <= kSame * size;
}

class Bdf2 final : public Integrator {
 public:
  Bdf2(Arena& a, const Params& p) : Integrator(a), dx_(&a), x_past_(&a), v_star_(&a), stage_(a, p) {}

  IntegratorInfo info() const override {
    IntegratorInfo i = unlimited_info(2, 2);
    i.l_stable = true;
    return i;
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::size_t n = x.size();
    const std::span<Vec3> low = low_of(field);
    dx_.assign(n, Vec3(0, 0, 0)), x_past_.resize(n), v_star_.assign(v.begin(), v.end());
    Real g = h;
    if (continues(h, x, v)) {
      const double w = static_cast<double>(h) / memory.numbers[0];
      g = static_cast<Real>((1 + w) / (1 + 2 * w) * static_cast<double>(h));
      const Real past = static_cast<Real>(w * w / (1 + 2 * w));
      const std::span<const Vec3> dx_before = part(0, n), v_before = part(1, n);
      for (std::size_t i = 0; i < n; ++i) {
        dx_[i] = past * dx_before[i];
        v_star_[i] = v[i] + past * (v[i] - v_before[i]);
      }
    }
    memory.points.resize(4 * n), memory.numbers.assign(1, static_cast<double>(h));
    std::copy(v.begin(), v.end(), part(1, n).begin());
    const std::span<const Real> inv_mass = field.inv_mass();
    for (std::size_t i = 0; i < n; ++i) {
      if (inv_mass[i] == 0) dx_[i] = Vec3(0, 0, 0), v_star_[i] = v[i];
      x_past_[i] = low[i] + dx_[i];
    }

    stage_.solve(field, {t + static_cast<double>(h), g, x, x_past_, v_star_}, v, stats);
    for (std::size_t i = 0; i < n; ++i) {
      part(0, n)[i] = inv_mass[i] != 0 ? Vec3(dx_[i] + g * v[i]) : Vec3(0, 0, 0);
      add_compensated(x[i], low[i], part(0, n)[i]);
    }
    std::copy(x.begin(), x.end(), part(2, n).begin());
    std::copy(v.begin(), v.end(), part(3, n).begin());
  }

 private:
  // last displacement, v before it, x left, v left
  std::span<Vec3> part(std::size_t k, std::size_t n) { return {memory.points.data() + k * n, n}; }

  bool continues(Real h, std::span<const Vec3> x, std::span<const Vec3> v) {
    const std::size_t n = x.size();
    if (memory.points.size() != 4 * n || memory.numbers.empty()) return false;
    if (!(static_cast<double>(h) <= kMaxGrowth * memory.numbers[0])) return false;
    return same(x, part(2, n)) && same(v, part(3, n));
  }

  Array<Vec3> dx_, x_past_, v_star_;
  ImplicitStage stage_;
};

}  // namespace

Variant<Integrator> integrate_bdf2() {
  return variant_of<Integrator, Bdf2>(
      "bdf2", "order 2, stable at any step and stiffness, one solve; remembers a step, fresh starts at contacts");
}

}  // namespace feder
