// What continuous collision asks: the colliders in the way of one, and when it meets them.
#include <algorithm>

#include "collide/impl.h"
#include "geom/width.h"
#include "narrow/impact.h"

namespace feder {

// A body stops this part of the margin before it touches: near enough to be in contact in the next step.
static constexpr Real kStopShort = Real(1) / 4;
// Two moving bodies may come nearer by so many depths of the thinner one's core before what comes is looked for.
static constexpr Real kFreeDepths = 2;
static constexpr Real kFarArm = Real(1e6);  // m, for what has no bounds

Real Collide::core_depth(const Shape& shape) const {
  const Real half = least_half_width(shape);
  return half > 0 ? (1 - kCoreScale) * half : kInfinity;
}

// Do two moving bodies come nearer in a step by more than leaves them in each other by a quarter of the thinner one?
bool Collide::Impl::may_pass(std::uint32_t a, std::uint32_t b, Real dt) const {
  const Colliders& c = *colliders;
  const Vec3 nearer = dt * (c.velocity[b] - c.velocity[a]);
  const Real free = kFreeDepths * (1 - kCoreScale) * std::min(seen[a].half_width, seen[b].half_width);
  if (!(dot(nearer, nearer) > free * free)) return false;
  const auto moves = [&](std::uint32_t i) {
    return c.owner[i] == ColliderOwner::body && c.motion[i] != ColliderMotion::fixed && c.shape[i]->convex();
  };
  return moves(a) && moves(b) && dot(nearer, c.center[b] - c.center[a]) < 0;
}

int find_field_kind() {
  const auto kinds = shape_kinds();
  const auto it =
      std::find_if(kinds.begin(), kinds.end(), [](const ShapeKind& kind) { return kind.fields != nullptr; });
  return it == kinds.end() ? -1 : static_cast<int>(it - kinds.begin());
}

// How a collider's owner moves in this step, as it moves now.
Sweep Collide::Impl::sweep_of(std::uint32_t i, Real dt) const {
  const Colliders& c = *colliders;
  const Pose owner{c.center[i], c.pose[i].rotation * conjugate(c.local[i].rotation)};
  return {c.shape[i],     c.local[i],        owner, dt * c.velocity[i], dt * c.angular_velocity[i],
          seen[i].extent, seen[i].half_width};
}

// The manifolds at that fraction of the step. `ahead`: how far b's centre comes nearer until then; `nearer`(n, k): by
// how much the point k of the manifold n does, along the normal.
template <class F>
int Collide::Impl::collide_at(Real time, const Sweep& a, const Sweep& b, Real margin, PairCache& cache, Manifold* found,
                              Vec3& ahead, F&& nearer) {
  const int count = narrow.collide(*a.shape, a.at(time), *b.shape, b.at(time), margin, cache, found);
  ahead = time * (b.shift - a.shift);
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < found[n].count; ++k) {
      ManifoldPoint& q = found[n].points[k];
      q.position -= time * a.shift;
      const Vec3 arm_a = q.position - a.from.position, arm_b = q.position - b.from.position - ahead;
      const Vec3 by = ahead + time * (cross(b.turn, arm_b) - cross(a.turn, arm_a));
      q.separation -= nearer(dot(by, found[n].normal));
    }
  return count;
}

// Where two bodies that are apart will meet in this step, as they move now: the manifold of that time, with the gaps of
// now, so that the solver lets them close and no more. Only what would reach the core counts: a corner that brushes
// along is left to the next step.
int Collide::Impl::look_ahead(std::uint32_t a, std::uint32_t b, Real margin, Real dt, Manifold* found, Vec3& ahead) {
  const Sweep sweep_a = sweep_of(a, dt), sweep_b = sweep_of(b, dt);
  const Real time = time_of_impact(sweep_a, sweep_b, 0, 1, margin / 2).time;
  if (!(time <= 1)) return 0;
  PairCache cache;
  return collide_at(time, sweep_a, sweep_b, margin, cache, found, ahead,
                    [](Real closer) { return std::min(closer, Real(0)); });
}

// Of a distance field, whose surface curves under the contact: in the middle of the step. Normals of its beginning push
// what rolls or swings under load too late and feed it: by (k dt^2/m)/4 per step, where the load over the radius is k.
int Collide::Impl::collide_midway(std::uint32_t a, std::uint32_t b, Real margin, Real dt, PairCache& cache,
                                  Manifold* found, Vec3& ahead) {
  const Sweep sweep_a = sweep_of(a, dt), sweep_b = sweep_of(b, dt);
  const Real way = length(sweep_b.shift - sweep_a.shift) + length(sweep_a.turn) * std::min(sweep_a.extent, kFarArm) +
                   length(sweep_b.turn) * std::min(sweep_b.extent, kFarArm);
  Real time = Real(0.5);
  if (way * time > margin) time = margin / way;
  return collide_at(time, sweep_a, sweep_b, margin, cache, found, ahead, [](Real closer) { return closer; });
}

void Collide::obstacles(std::uint32_t collider, const Aabb& box, bool moving, Array<std::uint32_t>& found) const {
  const Impl& s = *impl_;
  const Colliders& c = *s.colliders;
  if (moving || s.scenery_changed)
    s.broad->query(box, found);
  else
    s.broad->query_still(box, found);
  const auto out = [&](std::uint32_t k) {
    if (c.sensor[k] || c.owner[k] != ColliderOwner::body || !s.may_collide(collider, k)) return true;
    return !moving && (c.motion[k] == ColliderMotion::dynamic || c.awake[k]);
  };
  found.erase(std::remove_if(found.begin(), found.end(), out), found.end());
}

OwnerImpact Collide::impact(std::uint32_t a, const OwnerMotion& motion_a, std::uint32_t b, const OwnerMotion& motion_b,
                            Real begin, Real end) const {
  const Impl& s = *impl_;
  const Colliders& c = *s.colliders;
  if (!c.shape[a]->convex() && !s.is_field(a)) return {};
  const Real extent = std::min(s.seen[a].extent, s.seen[b].extent);
  const Real margin = std::min(kSpeculative, kSpeculativeShare * extent);
  const Sweep sweep_a{c.shape[a],    c.local[a],       motion_a.from,       motion_a.shift,
                      motion_a.turn, s.seen[a].extent, s.seen[a].half_width};
  const Sweep sweep_b{c.shape[b],    c.local[b],       motion_b.from,       motion_b.shift,
                      motion_b.turn, s.seen[b].extent, s.seen[b].half_width};
  const Impact hit = time_of_impact(sweep_a, sweep_b, begin, end, kStopShort * margin);
  return {hit.time, hit.normal, hit.point, hit.inside};
}

}  // namespace feder
