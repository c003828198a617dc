// Circle against polygon: the nearest point of the outline; a centre inside the core leaves by the nearest edge.
// Source: Ericson, "Real-Time Collision Detection" (2005), 5.1.2, edge by edge. Keeps nothing between calls. Weak spot:
// the normal of a centre inside jumps where two edges are equally near.
#include "geom/polygon.h"
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

struct Nearest {
  Vec2 point, outward;    // outward: unit, towards the centre when that is outside
  Real distance;          // negative inside
  std::uint32_t feature;  // 2 i: edge i, 2 i + 1: corner i
};

Nearest nearest_on_outline(const Polygon& polygon, const Vec2& c) {
  const auto points = polygon.points(), normals = polygon.normals();
  const std::size_t n = points.size();
  Nearest edge{Vec2::Zero(), Vec2::Zero(), -kInfinity, 0}, outside{Vec2::Zero(), Vec2::Zero(), kInfinity, 0};
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &p = points[i], e = points[(i + 1) % n] - p;
    const Real height = normals[i].dot(c - p), t = clamp((c - p).dot(e) / e.squaredNorm(), 0, 1);
    const std::uint32_t f = 2 * static_cast<std::uint32_t>(t < 1 ? i : (i + 1) % n) + (t > 0 && t < 1 ? 0u : 1u);
    const Vec2 near = p + t * e;
    if (height > edge.distance) edge = {near, normals[i], height, f};
    const Real d = (c - near).norm();
    if (d < outside.distance) outside = {near, d > 0 ? Vec2((c - near) / d) : normals[i], d, f};
  }
  return edge.distance <= 0 ? edge : outside;
}

int circle_polygon(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                   Manifold* out) {
  const Vec3 c = to_local(pose_b, pose_a.position);
  const Nearest near = nearest_on_outline(static_cast<const Polygon&>(b), Vec2(c[0], c[1]));
  const Real separation = near.distance - a.radius() - b.radius();
  if (separation > margin) return 0;
  const Vec3 n = rotate(pose_b.rotation, vec3(near.outward[0], near.outward[1], 0));
  const Vec3 p = to_world(pose_b, vec3(near.point[0], near.point[1], 0));
  out->normal = -n;
  out->count = 1;
  out->points[0] = {p + n * (b.radius() + separation / 2), separation, near.feature};
  return 1;
}

}  // namespace

PairRow narrow_circle_polygon() { return {"circle", "polygon", circle_polygon}; }

}  // namespace feder
