// Polygon against polygon, rounded or not. Cores apart: GJK, which stays in the plane. Cores that overlap: separating
// axes over the edge normals of both (EPA would find no depth across the plane). Then the common stretch of the two
// edges, as for solids.
// Source of the axes: Ericson, "Real-Time Collision Detection" (2005), 5.2.1. Keeps nothing between calls. Weak spot:
// every edge asks for a support point of the other, so an overlap costs the product of the corners.
#include "geom/polygon.h"

#include "narrow/narrow_phase.h"
#include "narrow/patch.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr double kPreference = 1e-3;  // of the size: how much better an edge of b must be than one of a

// The edge of `own` with the largest gap to the other core.
template <class Support>
Gap best_edge(const Polygon& own, const Support& lowest) {
  Gap best;
  best.distance = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < own.points().size(); ++i) {
    const Vec2 &p = own.points()[i], &m = own.normals()[i];
    const Double3 n{m[0], m[1], 0}, at{p[0], p[1], 0}, other = lowest(n);
    const double gap = dot(n, other - at);
    if (gap > best.distance) best = {gap, other - gap * n, other, n};
  }
  return best;
}

Gap overlap_gap(const ConvexPair& pair, const Polygon& a, const Polygon& b) {
  const Gap ga = best_edge(
      a, [&](const Double3& n) { return pair.from_b(wide(pair.b.support(narrow(pair.direction_to_b(-n))))); });
  const Gap gb = best_edge(b, [&](const Double3& n) {  // in the frame of b
    const Double3 in_a = pair.from_b(n) - pair.offset, s = wide(pair.a.support(narrow(-in_a))) - pair.offset;
    return pair.direction_to_b(s);
  });
  const double size = std::max(a.extent(Vec3::Zero()), b.extent(Vec3::Zero()));
  if (gb.distance <= ga.distance + kPreference * size) return ga;
  return {gb.distance, pair.from_b(gb.b), pair.from_b(gb.a), pair.offset - pair.from_b(gb.normal)};
}

int polygon_polygon(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                    Manifold* out) {
  ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  pair.offset.z = 0;
  const double enough = double(margin) + a.radius() + b.radius();
  Simplex simplex;
  Gap gap;
  if (!gjk_distance(pair, -pair.offset, enough, simplex, gap))
    gap = overlap_gap(pair, static_cast<const Polygon&>(a), static_cast<const Polygon&>(b));
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
