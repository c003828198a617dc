// Time spent in a pass or loop of the step plan, ns of the steady clock.
#pragma once
#include <chrono>

#include "feder/types.h"

namespace feder {

struct Counter {
  std::uint64_t calls = 0;
  std::uint64_t clocked = 0;      // calls that were measured
  std::uint64_t nanoseconds = 0;  // in these
  // Of all calls, extrapolated from those that were measured.
  double total_nanoseconds() const {
    return clocked ? static_cast<double>(nanoseconds) * static_cast<double>(calls) / static_cast<double>(clocked) : 0;
  }
};

inline std::uint64_t clock_nanoseconds() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
          .count());
}

}  // namespace feder
