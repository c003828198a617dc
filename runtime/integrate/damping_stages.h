// Coefficients of a Runge-Kutta-Chebyshev method for y' = -A y over a time of 1 (van der Houwen and Sommeijer 1980;
// Verwer, Hundsdorfer and Sommeijer 1990, eq. 2.3 ff., first order): s stages are stable to 1.07 s^2.
#pragma once

namespace feder {

// y_j = y_0 + d_j, d_j = mu d_(j-1) + nu d_(j-2) + rate (A y_0 + A d_(j-1)), d_0 = d_-1 = 0.
struct DampingStage {
  double mu = 0, nu = 0, rate = 0;
};

// The stages one after another, first order, for eigenvalues of A up to `stability_limit`; modes there are left with a
// third of their size at most.
class DampingStages {
 public:
  explicit DampingStages(int count);
  double stability_limit() const { return (w0_ + 1) / w1_; }
  DampingStage next();
  // The fewest stages whose limit is at least z, but no more than `max_count`.
  static int needed(double z, int max_count);

 private:
  int at_ = 0;
  double w0_ = 0, w1_ = 0;     // T_s(w0 + w1 z)/T_s(w0) is what is left of a mode
  double last_ = 0, now_ = 0;  // T_(j-1)(w0), T_j(w0)
};

}  // namespace feder
