// Polygon against polygon, rounded or not. Cores apart: GJK, which stays in the plane. Cores that overlap: separating
// axes (polygon_axes.cpp), as EPA would find no depth across the plane. Then the common stretch of the two edges, as
// for solids. Keeps nothing between calls.
#include "narrow/narrow_phase.h"
#include "narrow/patch.h"
#include "narrow/polygon_axes.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

int polygon_polygon(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                    Manifold* out) {
  ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  pair.offset.z = 0;
  const double enough = double(margin) + a.radius() + b.radius();
  Simplex simplex;
  Gap gap;
  if (!gjk_distance(pair, -pair.offset, enough, simplex, gap))
    gap = polygon_overlap(pair, static_cast<const Polygon&>(a), static_cast<const Polygon&>(b));
  if (gap.distance > enough) return 0;
  Patch patch;
  contact_patch(pair, gap, margin, patch);
  reduce_points({patch.points, static_cast<std::size_t>(patch.count)}, patch.normal, *out);
  out->normal = rotate(pose_a.rotation, patch.normal);
  for (int i = 0; i < out->count; ++i) out->points[i].position = to_world(pose_a, out->points[i].position);
  return 1;
}

}  // namespace

PairRow narrow_polygon_polygon() { return {"polygon", "polygon", polygon_polygon}; }

}  // namespace feder
