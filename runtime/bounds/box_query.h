// One box against many: the six comparisons of an overlap test as two of four lanes.
#pragma once
#include <cstring>

#include "feder/types.h"

namespace feder {

// meets(b) == overlaps(b, box) for boxes without NaN.
class BoxQuery {
 public:
  explicit BoxQuery(const Aabb& box)
      : most_{box.hi[0], box.hi[1], box.hi[2], kInfinity}, least_{-kInfinity, box.lo[0], box.lo[1], box.lo[2]} {}

  bool meets(const Aabb& b) const {
    static_assert(sizeof(Aabb) == 6 * sizeof(Real));
    const char* at = reinterpret_cast<const char*>(&b);
    Four from, to;  // lo and the first of hi; the last of lo and hi
    std::memcpy(&from, at, sizeof from), std::memcpy(&to, at + 2 * sizeof(Real), sizeof to);
    const auto inside = (from <= most_) & (to >= least_);
#if defined(__SSE__) && !defined(FEDER_REAL_DOUBLE)
    return __builtin_ia32_movmskps(reinterpret_cast<Four>(inside)) == 15;
#else
    return (inside[0] & inside[1] & inside[2] & inside[3]) != 0;
#endif
  }

 private:
  using Four [[gnu::vector_size(4 * sizeof(Real))]] = Real;
  Four most_, least_;
};

}  // namespace feder
