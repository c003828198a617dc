// Argument reduction: Cody and Waite in three parts (Muller, "Elementary Functions", 2nd ed., 9.1) up to 1.6e6, beyond
// that Payne and Hanek ("Radian Reduction for Trigonometric Functions", 1983) with integers: of x * 2/pi only the bits
// that matter modulo 4 are computed, 192 of them. The polynomials are Taylor's on |r| <= pi/4.
#include "base/trig.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace feder {
namespace {

// pi/2 = kPart1 + kPart2 + kPart3; the first two have 33 bits, so that products with 20 bits are exact.
constexpr double kPart1 = 0x1.921fb54400000p+0, kPart2 = 0x1.0b4611a600000p-34, kPart3 = 0x1.3198a2e037073p-69;
constexpr double kHalfPi = 0x1.921fb54442d18p+0, kHalfPiRest = 0x1.1a62633145c07p-54;
constexpr double kCodyWaiteLimit = 1.6e6;  // below 2^20 quadrants

// Bits of 2/pi behind the point; two words of zeros before them, for exponents below 2.
constexpr int kZeroWords = 2;
constexpr std::uint32_t kTwoOverPi[] = {
    0,          0,          0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
    0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
    0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b,
    0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab};
constexpr int kWords = 6;  // of the fraction

struct Reduced {
  int quadrant;    // of x, 0 to 3
  double r, rest;  // r + rest = x - k pi/2, |r| <= pi/4 and a little
};

// a + b = sum + error, exactly (Knuth 1969).
double two_sum(double a, double b, double& error) {
  const double sum = a + b, shifted = sum - a;
  error = (a - (sum - shifted)) + (b - shifted);
  return sum;
}

// The upper 26 bits (Dekker 1971).
double upper_half(double a) {
  const double c = 134217729.0 * a;  // 2^27 + 1
  return c - (c - a);
}

// a * b = product + error, exactly (Dekker 1971).
double two_product(double a, double b, double& error) {
  const double product = a * b, a1 = upper_half(a), a2 = a - a1, b1 = upper_half(b), b2 = b - b1;
  error = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
  return product;
}

Reduced reduce_small(double x) {
  const double k = std::floor(x / kHalfPi + 0.5);
  double e1, e2;
  const double a = two_sum(x - k * kPart1, -(k * kPart2), e1);  // the first difference is exact
  const double r = two_sum(a, e1 - k * kPart3, e2);
  return {static_cast<int>(static_cast<long>(k) & 3), r, e2};
}

// 32 bits of 2/pi from bit `at` on (of the table).
std::uint32_t bits_at(int at) {
  const int word = at / 32, shift = at % 32;
  const std::uint64_t both =
      static_cast<std::uint64_t>(kTwoOverPi[word]) << 32 | (shift == 0 ? 0u : kTwoOverPi[word + 1]);
  return static_cast<std::uint32_t>(both >> (32 - shift));
}

Reduced reduce_large(double x) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  const int exponent = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const std::uint64_t m = (bits & 0xfffffffffffffull) | 0x10000000000000ull;  // |x| = m 2^exponent
  // y = m * (2/pi * 2^(exponent - 2) mod 1) mod 1 is x in turns
  const int start = exponent - 2 + 32 * kZeroWords;
  std::uint32_t y[kWords] = {};
  const std::uint64_t factors[2] = {m & 0xffffffffu, m >> 32};
  for (int f = 0; f < 2; ++f) {
    std::uint64_t carry = 0;
    // the upper half of m counts one word further up
    for (int i = kWords - 1 - f; i >= 0; --i) {
      const std::uint64_t t = factors[f] * bits_at(start + 32 * (i + f)) + y[i] + carry;
      y[i] = static_cast<std::uint32_t>(t);
      carry = t >> 32;
    }
  }
  int quadrant = static_cast<int>(y[0] >> 30);
  // the fraction of a quarter, as a signed number from -1/2 to 1/2
  for (int i = 0; i < kWords; ++i) y[i] = y[i] << 2 | (i + 1 < kWords ? y[i + 1] >> 30 : 0);
  const bool above = (y[0] & 0x80000000u) != 0;
  if (above) {
    quadrant = (quadrant + 1) & 3;
    for (std::uint32_t& word : y) word = ~word;  // 1 - f, but for 2^-192
  }
  double high = 0, low = 0, scale = 1;
  for (std::uint32_t word : y) {
    scale *= 1.0 / 4294967296.0;
    double error;
    high = two_sum(high, static_cast<double>(word) * scale, error);
    low += error;
  }
  double error, rest;
  const double product = two_product(high, kHalfPi, error);
  const double r = two_sum(product, error + (high * kHalfPiRest + low * kHalfPi), rest);
  const bool negative = above != (x < 0);
  if (x < 0) quadrant = (4 - quadrant) & 3;
  return {quadrant, negative ? -r : r, negative ? -rest : rest};
}

Reduced reduce(double x) { return std::fabs(x) < kCodyWaiteLimit ? reduce_small(x) : reduce_large(x); }

// sine of x + quarter * pi/2
double wave(const Reduced& a, int quarter) {
  const double s = taylor_sine(a.r), c = taylor_cosine(a.r);
  const double sine = s + a.rest * c, cosine = c - a.rest * s;
  switch ((a.quadrant + quarter) & 3) {
    case 0: return sine;
    case 1: return cosine;
    case 2: return -sine;
    default: return -cosine;
  }
}

}  // namespace

double sine(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0) return x;  // keeps the sign
  return wave(reduce(x), 0);
}

double cosine(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  return wave(reduce(x), 1);
}

double tangent(double x) {
  if (!std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0) return x;
  const Reduced a = reduce(x);
  return wave(a, 0) / wave(a, 1);
}

}  // namespace feder
