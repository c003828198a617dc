// Conditions on numbers that asserts share. Of numbers gone bad (NaN, overflow, underflow) they say nothing: those are
// the scene's, and dealt with where they are found.
#pragma once
#include <span>

#include "feder/error.h"
#include "feder/types.h"

namespace feder {

// A direction as normalized_or leaves it, not a vector that nobody normalised. Wide, because the length of what is
// shorter than 1e-22 is rounded to a few bits; zero is what is left of a vector whose length overflowed.
inline bool is_direction(const Vec3& n) {
  const Real nn = dot(n, n);
  return !(nn > 0) || (nn > Real(0.25) && nn < 4);
}

// Weights of a point among the corners of something.
inline bool sums_to(std::span<const Real> weights, Real total) {
  Real sum = 0;
  for (const Real w : weights) sum += w;
  return !(std::abs(sum - total) > Real(1e-3));
}

// To a thousandth of what they are made of.
inline bool nearly_equal(double a, double b) {
  return !(std::fabs(a - b) > 1e-3 * (std::fabs(a) + std::fabs(b)) + 1e-30);
}

}  // namespace feder
