// Distance, overlap and sweeps of single shapes. The sweep is conservative advancement (Mirtich 1996): the distance
// divided by the closing speed can always be travelled, and for a translation it converges to the first touch.
// Keeps nothing between calls. Weak spot: grazing sweeps converge slowly; one that has not touched after kMaxAdvances
// counts as a miss.
#include <algorithm>

#include "geom/width.h"
#include "narrow/field_tools.h"
#include "narrow/gjk.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

constexpr int kMaxAdvances = 64;
constexpr double kTouch = 1e-5;  // of the moving shape's size: as near as this is a hit

Double3 to_world(const Pose& p, const Double3& v) { return wide(p.position) + wide(rotate(p.rotation, narrow(v))); }

// Sweeps a against one convex b; keeps the hit when it is earlier than hit.fraction.
bool cast_convex(const Convex& a, const Pose& pose_a, const Vec3& motion, Real size, const Convex& b,
                 const Pose& pose_b, CastHit& hit) {
  const double radii = double(a.radius) + b.radius, touch = kTouch * size;
  const double limit = hit.fraction;
  double t = 0;
  Pose pose = pose_a;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const ConvexPair pair(a, pose, b, pose_b);
    Gap gap;
    core_gap(pair, -pair.offset, std::numeric_limits<double>::infinity(), gap);
    const Vec3 n = rotate(pose.rotation, narrow(gap.normal));
    const double distance = gap.distance - radii, closing = dot(wide(motion), wide(n));
    if (distance <= touch) {
      if (t > 0 && closing <= 0) return false;  // brushes past
      hit = {Real(t), narrow(to_world(pose, gap.b)) - n * b.radius, -n};
      return true;
    }
    if (closing <= 0) return false;
    t += distance / closing;
    if (t >= limit) return false;
    pose.position = pose_a.position + Real(t) * motion;
  }
  return false;
}

// Against the half-space n.(x - origin) <= distance.
bool cast_half_space(const Convex& a, const Pose& pose_a, const Vec3& motion, const Vec3& n, Real distance,
                     const Vec3& origin, CastHit& hit) {
  const Vec3 low = to_world(pose_a, a.support(rotate_inverse(pose_a.rotation, -n))) - n * a.radius;
  const Real height = dot(n, low - origin) - distance, down = -dot(n, motion);
  if (height > 0 && !(down > 0 && height < down * hit.fraction)) return false;
  const Real t = height > 0 ? height / down : Real(0);
  hit = {t, low + t * motion, n};
  return true;
}

struct MeshCast {
  const Convex& a;
  const Pose& pose_a;
  const Vec3& motion;
  Real size;
  const Shape& mesh;
  const Pose& pose_b;
  CastHit& hit;
  bool found;
};

bool cast_mesh(const Convex& a, const Pose& pose_a, const Vec3& motion, Real size, const Shape& mesh,
               const Pose& pose_b, CastHit& hit) {
  const Pose local{to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation};
  Aabb swept = a.shape->bounds(local), end = swept;
  const Vec3 shift = rotate_inverse(pose_b.rotation, motion);
  end.lo += shift, end.hi += shift;
  swept.include(end);
  MeshCast cast{a, pose_a, motion, size, mesh, pose_b, hit, false};
  const auto visit = [](void* context, std::uint32_t index) {
    MeshCast& c = *static_cast<MeshCast*>(context);
    const Triangle& t = c.mesh.triangle(index);
    const Vec3 corners[3] = {t.a, t.b, t.c};
    if (cast_convex(c.a, c.pose_a, c.motion, c.size, Convex(corners, 3), c.pose_b, c.hit)) c.found = true;
  };
  mesh.triangles_in(swept, visit, &cast);
  return cast.found;
}

// Conservative advancement by the least distance of the field over the core, sought from its middle.
bool cast_field(const Shape& a, const Pose& pose_a, const Vec3& motion, Real size, const Shape& b, const Pose& pose_b,
                const FieldTools& tools, CastHit& hit) {
  const Convex core(a);
  const Vec3 middle = inner_point(a);
  Real t = 0;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const Pose at_t{pose_a.position + t * motion, pose_a.rotation};
    const Pose place{to_local(pose_b, at_t.position), conjugate(pose_b.rotation) * at_t.rotation};
    Vec3 at, n;
    const Real d = tools.least(b, core, place, to_world(place, middle), at, n);
    n = rotate(pose_b.rotation, n);
    const Real distance = d - a.radius(), closing = -dot(motion, n);
    if (distance <= Real(kTouch) * size) {
      if (t > 0 && closing <= 0) return false;  // brushes past
      hit = {t, to_world(pose_b, at) - n * d, n};
      return true;
    }
    // away from it here, but the field may bend towards the way: the distance itself can always be travelled
    t += distance / std::max(closing, length(motion) / 2);
    if (!(t < hit.fraction)) return false;
  }
  return false;
}

bool cast_into(const Shape& a, const Pose& pose_a, const Vec3& motion, const Shape& b, const Pose& pose_b,
               CastHit& hit) {
  bool found = false;
  if (const auto parts = a.parts(); !parts.empty()) {
    for (const CompoundPart& p : parts) found |= cast_into(*p.shape, pose_a * p.pose, motion, b, pose_b, hit);
    return found;
  }
  if (const auto parts = b.parts(); !parts.empty()) {
    for (const CompoundPart& p : parts) found |= cast_into(a, pose_a, motion, *p.shape, pose_b * p.pose, hit);
    return found;
  }
  if (!a.convex()) return false;
  const Real size = a.extent(Vec3::Zero());
  if (b.convex()) return cast_convex(Convex(a), pose_a, motion, size, Convex(b), pose_b, hit);
  Vec3 normal;
  Real distance;
  if (b.half_space(normal, distance))
    return cast_half_space(Convex(a), pose_a, motion, rotate(pose_b.rotation, normal), distance, pose_b.position, hit);
  if (const FieldTools* tools = field_tools(); tools && tools->is_field(b))
    return cast_field(a, pose_a, motion, size, b, pose_b, *tools, hit);
  return cast_mesh(Convex(a), pose_a, motion, size, b, pose_b, hit);
}

}  // namespace

ClosestResult closest_points(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  Gap gap;
  core_gap(pair, -pair.offset, std::numeric_limits<double>::infinity(), gap);
  ClosestResult result;
  result.normal = rotate(pose_a.rotation, narrow(gap.normal));
  result.point_a = narrow(to_world(pose_a, gap.a)) + result.normal * a.radius();
  result.point_b = narrow(to_world(pose_a, gap.b)) - result.normal * b.radius();
  result.distance = Real(std::max(0.0, gap.distance - a.radius() - b.radius()));
  if (result.distance == 0) result.point_a = result.point_b = (result.point_a + result.point_b) / 2;
  return result;
}

bool shapes_overlap(const NarrowPhase& narrow, const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  if (const auto parts = a.parts(); !parts.empty()) {
    for (const CompoundPart& p : parts)
      if (shapes_overlap(narrow, *p.shape, pose_a * p.pose, b, pose_b)) return true;
    return false;
  }
  if (!b.parts().empty()) return shapes_overlap(narrow, b, pose_b, a, pose_a);
  PairCache cache;
  Manifold manifolds[kMaxManifolds];
  const int count = narrow.collide(a, pose_a, b, pose_b, 0, cache, manifolds);
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < manifolds[i].count; ++k)
      if (manifolds[i].points[k].separation <= 0) return true;
  return false;
}

bool shape_cast(const Shape& a, const Pose& pose_a, const Vec3& motion, const Shape& b, const Pose& pose_b,
                CastHit& hit) {
  CastHit nearest;
  if (!cast_into(a, pose_a, motion, b, pose_b, nearest)) return false;
  hit = nearest;
  return true;
}

}  // namespace feder
