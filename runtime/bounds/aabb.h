// Axis-aligned bounding box.
#pragma once
#include "base/types.h"

namespace feder {

struct Aabb {
  Vec3 lo = Vec3::Constant(kInfinity);
  Vec3 hi = Vec3::Constant(-kInfinity);

  static Aabb everything() { return {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)}; }
  bool empty() const { return !(lo[0] <= hi[0]); }
  void include(const Vec3& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void include(const Aabb& b) { lo = lo.cwiseMin(b.lo), hi = hi.cwiseMax(b.hi); }
  void grow(Real margin) { lo.array() -= margin, hi.array() += margin; }
};

inline bool overlaps(const Aabb& a, const Aabb& b) {
  return a.lo[0] <= b.hi[0] && b.lo[0] <= a.hi[0] && a.lo[1] <= b.hi[1] && b.lo[1] <= a.hi[1] && a.lo[2] <= b.hi[2] &&
         b.lo[2] <= a.hi[2];
}

inline bool contains(const Aabb& outer, const Aabb& inner) {
  return outer.lo[0] <= inner.lo[0] && outer.lo[1] <= inner.lo[1] && outer.lo[2] <= inner.lo[2] &&
         inner.hi[0] <= outer.hi[0] && inner.hi[1] <= outer.hi[1] && inner.hi[2] <= outer.hi[2];
}

}  // namespace feder
