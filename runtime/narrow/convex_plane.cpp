// Any convex shape against a half-space: the corners of the face that looks into the plane, and the deepest point
// when no corner of that face is as deep (a sharp hull standing on a vertex).
// Keeps nothing between calls. Weak spot: a round cap stands on the corners of its outline (Shape::face), slightly
// inside its rim.
#include "geom/plane.h"
#include "narrow/narrow_phase.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

int convex_plane(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                 Manifold* out) {
  const Plane& plane = static_cast<const Plane&>(b);
  const Vec3 n = rotate(pose_b.rotation, plane.normal());
  // height of a local point of a over the surface: above + down . p
  const Vec3 down = rotate_inverse(pose_a.rotation, n);
  const Real above = dot(n, pose_a.position - pose_b.position) - plane.distance() - a.radius();
  const Vec3 deepest = a.support(-down);
  const Real depth = above + dot(down, deepest);
  if (depth > margin) return 0;

  Vec3 corner[kMaxFacePoints + 1];
  int corners = a.face(-down, corner);
  Real lowest = kInfinity;
  for (int i = 0; i < corners; ++i) lowest = std::min(lowest, above + dot(down, corner[i]));
  const Real same = Real(1e-5) * (length(deepest) + a.radius());
  if (depth < lowest - same) corner[corners++] = deepest;

  ManifoldPoint points[kMaxFacePoints + 1];
  int count = 0;
  for (int i = 0; i < corners; ++i) {
    const Real separation = above + dot(down, corner[i]);
    if (separation > margin) continue;
    const Vec3 midway = to_world(pose_a, corner[i]) - n * (a.radius() + separation / 2);
    points[count++] = {midway, separation, feature_of(corner[i])};
  }
  if (count == 0)
    points[count++] = {to_world(pose_a, deepest) - n * (a.radius() + depth / 2), depth, feature_of(deepest)};
  reduce_points({points, static_cast<std::size_t>(count)}, -n, *out);
  return 1;
}

}  // namespace

PairRow narrow_convex_plane() { return {"convex", "plane", convex_plane}; }

}  // namespace feder
