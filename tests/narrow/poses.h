// Random poses and the support-function oracle for narrow-phase tests.
#pragma once
#include "base/rng.h"
#include "feder/shape.h"
#include "feder/types.h"
#include "narrow/narrow_phase.h"

namespace feder {

inline Vec3 random_direction(Rng& rng, bool planar = false) {
  for (;;) {
    const Vec3 v = vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), planar ? Real(0) : rng.uniform(-1, 1));
    if (dot(v, v) > Real(0.01) && dot(v, v) <= 1) return v / length(v);
  }
}

inline Quat random_rotation(Rng& rng, bool planar = false) {
  return from_axis_angle(planar ? vec3(0, 0, 1) : random_direction(rng), rng.uniform(-kPi, kPi));
}

// Gap between two convex shapes along the unit vector n, from a to b: negative when their shadows on n overlap. No
// direction gives more than the true distance; an overlap's depth is the least shadow overlap of all directions.
inline Real gap_along(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, const Vec3& n) {
  const Vec3 sa = to_world(pa, a.support(rotate_inverse(pa.rotation, n)));
  const Vec3 sb = to_world(pb, b.support(rotate_inverse(pb.rotation, -n)));
  return dot(n, sb - sa) - a.radius() - b.radius();
}

struct Hit {
  int count = 0;
  Manifold m[kMaxManifolds];
};

inline Hit collide(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, Real margin) {
  static const NarrowPhase narrow("auto");
  PairCache cache;
  Hit hit;
  hit.count = narrow.collide(a, pa, b, pb, margin, cache, hit.m);
  return hit;
}

inline Real deepest(const Manifold* m, int count) {
  Real s = kInfinity;
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < m[i].count; ++k) s = std::min(s, m[i].points[k].separation);
  return s;
}

}  // namespace feder
