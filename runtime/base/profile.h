// Time spent in a row of the step plan.
#pragma once
#include <chrono>

#include "base/types.h"

namespace feder {

struct Counter {
  std::uint64_t calls = 0;
  std::uint64_t nanoseconds = 0;
};

inline std::uint64_t clock_nanoseconds() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
          .count());
}

}  // namespace feder
