// exp, log and pow from sums and products alone: the same digits on every machine.
#include "base/functions.h"

#include <cmath>
#include <limits>

namespace feder {

// x = n ln 2 + r with ln 2 in two parts, the first with 21 trailing zeros so that n times it is exact; e^r by its
// series.
double exponential(double x) {
  constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
  if (x != x) return x;
  if (x > 709.782712893384) return std::numeric_limits<double>::infinity();
  if (x < -745.14) return 0;
  const double n = std::floor(x / 0.69314718055994531 + 0.5);
  const double r = (x - n * kLn2High) - n * kLn2Low;  // |r| < 0.35
  double sum = 1;
  for (int k = 14; k >= 1; --k) sum = 1 + sum * r / k;  // the next term is below 1e-18
  return std::ldexp(sum, static_cast<int>(n));
}

// ln x = e ln 2 + 2 atanh((m-1)/(m+1)) with x = m 2^e, m in [sqrt(1/2), sqrt 2).
double natural_log(double x) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  if (!(x > 0)) return x == 0 ? -kInf : std::numeric_limits<double>::quiet_NaN();
  if (x == kInf) return x;
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < 0.70710678118654752) m *= 2, --e;
  const double z = (m - 1) / (m + 1), zz = z * z;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * zz + 1.0 / k;  // |z| < 0.172: the next term is below 1e-18
  return e * 0.69314718055994531 + 2 * z * sum;
}

double power(double a, double b) {
  if (a == 0) return b > 0 ? 0 : b == 0 ? 1 : std::numeric_limits<double>::infinity();
  const double twice = 2 * b;
  const bool whole = b == std::floor(b);
  if (twice == std::floor(twice) && std::fabs(b) <= 64 && (whole || a > 0)) {
    double result = whole ? 1 : std::sqrt(a), base = a;
    for (int n = static_cast<int>(std::fabs(b)); n > 0; n /= 2, base *= base)
      if (n % 2 == 1) result *= base;
    return b < 0 ? 1 / result : result;
  }
  if (a > 0) return exponential(b * natural_log(a));
  if (!whole) return std::numeric_limits<double>::quiet_NaN();
  const double size = exponential(b * natural_log(-a));
  return std::fmod(b, 2) == 0 ? size : -size;
}

}  // namespace feder
