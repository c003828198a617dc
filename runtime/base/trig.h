// Sine, cosine and tangent of any double: the argument is reduced by pi/2 without losing digits, so the error is below
// 1.5 units in the last place (tangent: 3.5) however large it is. The same bits on every machine. NaN for infinities.
#pragma once

namespace feder {

double sine(double x);
double cosine(double x);
double tangent(double x);
double arc_tangent2(double y, double x);  // of y/x, in the quadrant of both; error about 1e-15

// c[0], then c[k] - z times what was there: an alternating series, its last coefficient first.
template <int count>
double alternating_sum(const double (&c)[count], double z) {
  double sum = c[0];
  for (int k = 1; k < count; ++k) sum = c[k] - z * sum;
  return sum;
}

// Taylor's series, for |r| <= pi/4: coefficients 1/17! to 1/3!, and 1/16! to 1/2!.
inline double taylor_sine(double r) {
  static constexpr double kOdd[] = {1.0 / 355687428096000, 1.0 / 1307674368000, 1.0 / 6227020800, 1.0 / 39916800,
                                    1.0 / 362880,          1.0 / 5040,          1.0 / 120,        1.0 / 6};
  const double z = r * r;
  return r - r * z * alternating_sum(kOdd, z);
}

inline double taylor_cosine(double r) {
  static constexpr double kEven[] = {1.0 / 20922789888000, 1.0 / 87178291200, 1.0 / 479001600, 1.0 / 3628800,
                                     1.0 / 40320,          1.0 / 720,         1.0 / 24,        1.0 / 2};
  const double z = r * r;
  return 1.0 - z * alternating_sum(kEven, z);
}

}  // namespace feder
