#include "integrate/damping_stages.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"

namespace feder {
namespace {
constexpr double kLeft = 3;  // T_s(w0): 1/kLeft is left of the fastest modes
}  // namespace

// w0 = cosh(acosh(kLeft)/s), by its series; T_s'(w0) = s U_(s-1)(w0).
DampingStages::DampingStages(int count) {
  FEDER_ASSERT(count >= 1);
  const double x = 1.7627471740390861 / count, x2 = x * x;  // acosh(3)
  w0_ = 1 + x2 / 2 * (1 + x2 / 12 * (1 + x2 / 30 * (1 + x2 / 56 * (1 + x2 / 90 * (1 + x2 / 132)))));
  double t0 = 1, t1 = w0_, u0 = 0, u1 = 1;  // T_0, T_1; U_-1, U_0
  for (int j = 1; j < count; ++j) {
    const double t2 = 2 * w0_ * t1 - t0, u2 = 2 * w0_ * u1 - u0;
    t0 = t1, t1 = t2, u0 = u1, u1 = u2;
  }
  w1_ = t1 / (count * u1);
  FEDER_ASSERT(w0_ > 1 && w1_ > 0 && std::fabs(t1 - kLeft) < 0.01);
  last_ = 0, now_ = 1;
}

DampingStage DampingStages::next() {
  DampingStage s;
  if (at_++ == 0) {
    last_ = 1, now_ = w0_;
    s.rate = w1_ / w0_;
    return s;
  }
  const double then = 2 * w0_ * now_ - last_;
  FEDER_ASSERT(then > now_ && then < 1.01 * kLeft);  // one stage more than asked for goes beyond
  s.mu = 2 * w0_ * now_ / then, s.nu = -last_ / then, s.rate = 2 * w1_ * now_ / then;
  last_ = now_, now_ = then;
  return s;
}

int DampingStages::needed(double z, int max_count) {
  int s =
      std::max(1, static_cast<int>(std::sqrt(std::fmin(z, 1e12) / 1.4)));  // the limit is 1.33 s^2 for 1, less after
  FEDER_ASSERT(s >= 1 && max_count >= 1);
  while (s < max_count && DampingStages(s).stability_limit() < z) ++s;
  return std::min(s, max_count);
}

}  // namespace feder
