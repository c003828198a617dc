// Points in groups of eight for the kernels of points_wide.h.
#pragma once
#include <vector>

#include "base/wide.h"
#include "feder/types.h"
#include "geom/points_wide.h"

namespace feder {

inline const PointKernel* point_kernel() {
#if defined(__x86_64__) || defined(__i386__)
  if (runs_avx2()) return &kPointsAvx2;
#endif
  return &kPointsPlain;
}

// What is left of the last group repeats the first. `point(i)`: the i-th of `count`.
template <class Point>
std::vector<Lane8x3> grouped(std::size_t count, Point&& point) {
  std::vector<Lane8x3> groups((count + kLanes - 1) / kLanes);
  for (std::size_t i = 0; i < groups.size() * kLanes; ++i) {
    const Vec3& p = point(i < count ? i : 0);
    Lane8x3& g = groups[i / kLanes];
    g.x.v[i % kLanes] = p[0], g.y.v[i % kLanes] = p[1], g.z.v[i % kLanes] = p[2];
  }
  return groups;
}

inline unsigned groups_in(const std::vector<Lane8x3>& groups) { return static_cast<unsigned>(groups.size()); }

// Of the points under a pose.
inline Aabb bounds_of(const std::vector<Lane8x3>& groups, const Pose& pose) {
  const Mat3 r = to_matrix(pose.rotation);
  const Real rows[9] = {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)};
  Real lo[3], hi[3];
  point_kernel()->bounds(groups.data(), groups_in(groups), rows, lo, hi);
  return {vec3(lo[0], lo[1], lo[2]) + pose.position, vec3(hi[0], hi[1], hi[2]) + pose.position};
}

}  // namespace feder
