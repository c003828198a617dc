// Segment against box, by slabs. Monotone under rounding: a box that encloses a hit box is hit too, so a tree that
// prunes with it finds what a linear scan finds.
#pragma once
#include "feder/types.h"

namespace feder {

// Does the closed segment origin + t ray, t in [0, 1], meet the closed box? Bounds may be infinite.
inline bool segment_hits(const Aabb& box, const Vec3& origin, const Vec3& ray) {
  Real first = 0, last = 1;
  for (int k = 0; k < 3; ++k) {
    if (ray[k] == 0) {
      if (!(box.lo[k] <= origin[k] && origin[k] <= box.hi[k])) return false;
      continue;
    }
    const Real lo = (box.lo[k] - origin[k]) / ray[k];
    const Real hi = (box.hi[k] - origin[k]) / ray[k];
    const Real enter = lo < hi ? lo : hi;
    const Real leave = lo < hi ? hi : lo;
    if (enter > first) first = enter;
    if (leave < last) last = leave;
    if (!(first <= last)) return false;
  }
  return true;
}

}  // namespace feder
