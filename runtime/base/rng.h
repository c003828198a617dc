// PCG32 (O'Neill 2014): small, seedable, the same everywhere.
#pragma once
#include "feder/types.h"

namespace feder {

class Rng {
 public:
  explicit Rng(std::uint64_t seed = 1, std::uint64_t stream = 54) : increment_(stream << 1 | 1) {
    next();
    state_ += seed;
    next();
  }
  std::uint32_t next() {
    const std::uint64_t old = state_;
    state_ = old * 6364136223846793005ull + increment_;
    const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto rotation = static_cast<std::uint32_t>(old >> 59);
    return shifted >> rotation | shifted << ((32 - rotation) & 31);
  }
  double unit() { return (next() >> 5) * (1.0 / 134217728.0); }  // [0, 1), 27 bits: enough for a float
  // [0, 1), all 53 bits of a double's mantissa, from two draws.
  double unit53() {
    const double high = static_cast<double>(next() >> 5), low = static_cast<double>(next() >> 6);
    return (high * 67108864.0 + low) * (1.0 / 9007199254740992.0);
  }
  Real uniform(Real lo, Real hi) { return lo + (hi - lo) * static_cast<Real>(unit()); }

 private:
  std::uint64_t state_ = 0;
  std::uint64_t increment_;
};

}  // namespace feder
