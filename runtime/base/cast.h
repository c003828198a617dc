// Numbers to integers without undefined behaviour.
#pragma once
#include <limits>

namespace feder {

// x without its fraction, held between lo and hi; NaN becomes lo.
template <class Int>
constexpr Int clamped_cast(double x, Int lo, Int hi) {
  return !(x > static_cast<double>(lo)) ? lo : !(x < static_cast<double>(hi)) ? hi : static_cast<Int>(x);
}

// For counts in messages: 0 to the largest.
constexpr long long whole_count(double x) {
  return clamped_cast<long long>(x, 0, std::numeric_limits<long long>::max());
}

}  // namespace feder
