// A segment in pieces about as long as a cell: boxes that cover them, for broad phases that look up cells.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "feder/types.h"

namespace feder {

// Calls visit(box) for boxes that together cover what of the segment may lie within `bounds`, each about `cell` (m)
// long. False, and nothing is called, when they would be more than `most`.
template <class F>
bool each_ray_piece(const Aabb& bounds, const Vec3& origin, const Vec3& ray, double cell, double most, F&& visit) {
  const double rounding = 8 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  double slack[3], first = 0, last = 1, longest = 0;
  for (int k = 0; k < 3; ++k) {
    const double o = origin[k], r = ray[k];
    slack[k] = rounding * (std::fabs(o) + std::fabs(r) + std::fabs(static_cast<double>(bounds.lo[k])) +
                           std::fabs(static_cast<double>(bounds.hi[k])));
    const double lo = static_cast<double>(bounds.lo[k]) - slack[k] - o,
                 hi = static_cast<double>(bounds.hi[k]) + slack[k] - o;
    if (std::fabs(r) <= slack[k]) {  // crosses at any time
      if (std::fmin(0, r) > hi || std::fmax(0, r) < lo) return true;
    } else {
      first = std::fmax(first, std::fmin(lo / r, hi / r)), last = std::fmin(last, std::fmax(lo / r, hi / r));
    }
    longest = std::fmax(longest, std::fabs(r));
  }
  if (!(first <= last)) return true;
  const double count = std::floor(longest * (last - first) / cell) + 1;
  if (!(count <= most)) return false;
  for (double n = 0; n < count; ++n) {
    const double from = first + (last - first) * (n / count), to = first + (last - first) * ((n + 1) / count);
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      const double a = origin[k] + ray[k] * from, b = origin[k] + ray[k] * to;
      box.lo[k] = static_cast<Real>(std::fmin(a, b) - slack[k]);
      box.hi[k] = static_cast<Real>(std::fmax(a, b) + slack[k]);
    }
    visit(box);
  }
  return true;
}

}  // namespace feder
