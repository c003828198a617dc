// Adaptive Runge-Kutta of order 5 (Dormand & Prince 1980): h is covered by as many steps as the error tolerance wants,
// their sizes chosen by a PI controller (Gustafsson 1991). Options: `tolerance`, relative, per step; `absolute`, the
// same in m and m/s (default: tolerance); `max_steps` within one h; `adaptive = false` takes h as one step. Nothing is
// remembered: each h is first tried whole, which costs a few thrown-away attempts where h is long, and nothing where it
// is short. When half of max_steps is spent, steps are at least so long that the other half suffices, whatever the
// error, counted as unconverged. Order and stability limit are those of one step; the error control cuts steps long
// before that limit. Kept between calls: work arrays. Weak spot: explicit, so stiff springs cost steps of 1/w; not
// symplectic.
#include <algorithm>
#include <cmath>

#include "integrate/dormand_prince.h"

namespace feder {
namespace {

constexpr bool kFloat = sizeof(Real) == 4;
constexpr double kTolerance = kFloat ? 1e-5 : 1e-8;
constexpr double kSmallest = 1e-9;  // step, of h
constexpr double kSafety = 0.9, kMinChange = 0.1, kMaxChange = 5;

// y^(1/5) by Newton's method from 1, y in [1e-12, 1e12]: no C library, the same bits everywhere.
double fifth_root(double y) {
  double r = y > 1 ? y : 1;
  for (int k = 0; k < 200; ++k) {
    const double next = r - (r - y / (r * r * r * r)) / 5;
    if (!(next < r)) break;
    r = next;
  }
  return r;
}

class Rk45 final : public Integrator {
 public:
  Rk45(Arena& a, const Params& p)
      : Integrator(a), tolerance_(p.number({"tolerance", "", {kFloat ? 1e-7 : 1e-15, 1}}, kTolerance)),
        absolute_(p.number({"absolute", "m, m/s", {0, 1e6}}, tolerance_)),
        max_steps_(p.integer({"max_steps", "", {1, 100000000}}, 10000)), adaptive_(p.flag({"adaptive"}, true)),
        pair_(a) {}

  IntegratorInfo info() const override {
    static constexpr double kPolynomial[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 600};
    return {.order = 5,
            .stability_limit = 0.997189008632,
            .evals_per_step = 7,
            .adaptive = adaptive_,
            .effort_option = "max_steps",
            .stability_polynomial = kPolynomial};
  }

  void step(ForceField& field, double t, Real h, std::span<Vec3> x, std::span<Vec3> v) override {
    const std::span<Vec3> low = low_of(field);
    pair_.start(field, t, x, low, v, stats);
    const double whole = h;
    int tries = 0;
    double done = 0, next = whole, error_before = 1;
    bool missed = false;
    while (done < whole) {
      const double rest = whole - done;
      const double smallest =
          ++tries <= max_steps_ / 2 ? kSmallest * whole : rest / std::max(1, max_steps_ + 1 - tries);
      double size = std::min(std::max(next, smallest), rest);
      if (rest - size < 0.01 * size) size = rest;  // no crumbs
      const double error =
          adaptive_ ? pair_.attempt(field, t + done, static_cast<Real>(size), x, low, v, absolute_, tolerance_, stats)
                    : whole_step(field, t, h, x, low, v);
      const bool good = error <= 1, stuck = size <= smallest;
      if (!good && !stuck) {
        ++stats.rejected;
        next = size * std::max(kMinChange, kSafety / fifth_root(clamped(error)));
        continue;
      }
      missed = missed || !good;
      std::copy(pair_.end_x().begin(), pair_.end_x().end(), x.begin());
      std::copy(pair_.end_low().begin(), pair_.end_low().end(), low.begin());
      std::copy(pair_.end_v().begin(), pair_.end_v().end(), v.begin());
      pair_.accept();
      ++stats.substeps;
      done = size >= rest ? whole : done + size;
      next = size * change(clamped(error), error_before);
      error_before = clamped(error);
      stats.residual = error;
    }
    if (missed) ++stats.unconverged;
  }

 private:
  double whole_step(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> low,
                    std::span<const Vec3> v) {
    pair_.attempt(field, t, h, x, low, v, 1, 0, stats);
    return 0;
  }
  static double clamped(double error) { return error <= 1e12 ? std::max(error, 1e-12) : 1e12; }
  // PI: error^(-3/8 of 1/5) (error_before/error)^(1/4 of 1/5), by square roots only
  static double change(double error, double error_before) {
    const double now = std::sqrt(fifth_root(error)), ratio = std::sqrt(fifth_root(error_before) / fifth_root(error));
    const double wanted = kSafety / std::sqrt(now) * std::sqrt(ratio) / std::sqrt(std::sqrt(now));
    return std::min(kMaxChange, std::max(0.2, wanted));
  }

  double tolerance_, absolute_;
  int max_steps_;
  bool adaptive_;
  DormandPrince pair_;
};

}  // namespace

Variant<Integrator> integrate_rk45() {
  return variant_of<Integrator, Rk45>(
      "rk45", "order 5, cuts h into steps by its error estimate: accurate where speeds vary much, not for stiffness");
}

}  // namespace feder
