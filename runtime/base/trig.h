// Sine, cosine and tangent of any double: the argument is reduced by pi/2 without losing digits, so the error is below
// 1.5 units in the last place (tangent: 3.5) however large it is. The same bits on every machine. NaN for infinities.
#pragma once

namespace feder {

double sine(double x);
double cosine(double x);
double tangent(double x);

// For |r| <= pi/4.
inline double taylor_sine(double r) {
  const double z = r * r;
  double s = 1.0 / 355687428096000.0;  // 1/17!
  s = 1.0 / 1307674368000.0 - z * s;   // 1/15!
  s = 1.0 / 6227020800.0 - z * s;
  s = 1.0 / 39916800.0 - z * s;
  s = 1.0 / 362880.0 - z * s;
  s = 1.0 / 5040.0 - z * s;
  s = 1.0 / 120.0 - z * s;
  s = 1.0 / 6.0 - z * s;
  return r - r * z * s;
}

inline double taylor_cosine(double r) {
  const double z = r * r;
  double c = 1.0 / 20922789888000.0;  // 1/16!
  c = 1.0 / 87178291200.0 - z * c;    // 1/14!
  c = 1.0 / 479001600.0 - z * c;
  c = 1.0 / 3628800.0 - z * c;
  c = 1.0 / 40320.0 - z * c;
  c = 1.0 / 720.0 - z * c;
  c = 1.0 / 24.0 - z * c;
  c = 0.5 - z * c;
  return 1.0 - z * c;
}

}  // namespace feder
