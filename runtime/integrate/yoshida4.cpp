// Yoshida's composition of order 4 (Yoshida 1990): three kick-drift-kick steps of w1 h, w0 h, w1 h with
// w1 = 1/(2 - 2^(1/3)), w0 = 1 - 2 w1 = -1.70 (backwards in time).
// The composition lifts the order from 2 to 4 only when the basic step is its own inverse in reverse, so damping is
// taken at the mean velocity of each kick, with a solve; `damping = "explicit"` kicks with the old velocity instead:
// order 1 where there is damping, no solves.
// Kept between calls: work arrays. Weak spot: the backward step undoes damping, so its limit shrinks with the damping
// ratio (h w = 1.57 undamped, 1.13 at 1) and stiff damping is out of reach; six force evaluations.
#include <cmath>

#include "integrate/damped_kick.h"

namespace feder {
namespace {

constexpr double kOuter = 1.3512071919596578, kInner = -1.7024143839193153;

// Largest stable h w with the damping ratio: the 2x2 matrix of the composition, scanned and bisected.
double composed_limit(double zeta, bool symmetric) {
  const auto unstable = [&](double z) {
    double m[2][2] = {{1, 0}, {0, 1}};
    for (const double share : {kOuter, kInner, kOuter}) {
      const double h = share * z, bottom = symmetric ? 1 + zeta * h / 2 : 1;
      const double stay = (symmetric ? 1 - zeta * h / 2 : 1 - zeta * h) / bottom, pull = h / 2 / bottom;
      for (const int c : {0, 1}) {
        double x = m[0][c], v = m[1][c];
        v = stay * v - pull * x;
        x += h * v;
        v = stay * v - pull * x;
        m[0][c] = x, m[1][c] = v;
      }
    }
    const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    return !(std::fabs(det) <= 1 + 1e-14 && std::fabs(m[0][0] + m[1][1]) <= 1 + det + 1e-14);
  };
  double below = 0, above = 1e-3;
  while (!unstable(above)) below = above, above += 1e-3;
  for (int k = 0; k < 60; ++k) {
    const double middle = (below + above) / 2;
    (unstable(middle) ? above : below) = middle;
  }
  return above;
}

class Yoshida4 final : public Integrator {
 public:
  Yoshida4(Arena& a, const Params& p)
      : Integrator(a), symmetric_(p.choice({.name = "damping", .choices = "symmetric, explicit"}) == 0), kick_(a) {}

  IntegratorInfo info() const override {
    return {.order = 4,
            .stability_limit = 1.57340194743454,
            .evals_per_step = 6,
            .symplectic = true,
            .damped_limit = symmetric_ ? symmetric_limit : explicit_limit};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    static constexpr double kShares[] = {kOuter, kInner, kOuter};
    const std::span<Vec3> low = low_of(field);
    double at = t;
    for (const double share : kShares) {
      const Real substep = static_cast<Real>(share) * h;
      kick(field, at, substep / 2, x, v);
      drift(field, substep, v, x, low);
      at += share * static_cast<double>(h);
      kick(field, at, substep / 2, x, v);
    }
  }

 private:
  static double symmetric_limit(double zeta) { return composed_limit(zeta, true); }
  static double explicit_limit(double zeta) { return composed_limit(zeta, false); }

  void kick(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v) {
    if (symmetric_ && field.damped())
      kick_.apply_implicit(field, t, h, Real(0.5), x, v, stats);
    else
      kick_.apply(field, t, h, x, v, stats);
  }

  bool symmetric_;
  DampedKick kick_;
};

}  // namespace

Variant<Integrator> integrate_yoshida4() {
  return variant_of<Integrator, Yoshida4>(
      "yoshida4", "order 4, three kick-drift-kick steps, keeps energy in the mean; for long accurate runs");
}

}  // namespace feder
