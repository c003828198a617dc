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

Real Collide::core_depth(const Shape& shape) const {
  return shape.convex() ? (1 - kCoreScale) * least_half_width(shape) : kInfinity;
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

// Where two bodies that are apart will meet in this step, as they move now: the manifold of that time, with the gaps of
// now, so that the solver lets them close and no more. `ahead`: how far b's centre comes nearer until then. Only what
// would reach the core counts: a corner that brushes along is left to the next step.
int Collide::Impl::look_ahead(std::uint32_t a, std::uint32_t b, Real margin, Real dt, Manifold* found, Vec3& ahead) {
  const Colliders& c = *colliders;
  const auto sweep = [&](std::uint32_t i) {
    const Pose owner{c.center[i], c.pose[i].rotation * conjugate(c.local[i].rotation)};
    return Sweep{c.shape[i],     c.local[i],        owner, dt * c.velocity[i], dt * c.angular_velocity[i],
                 seen[i].extent, seen[i].half_width};
  };
  const Sweep sweep_a = sweep(a), sweep_b = sweep(b);
  const Real time = time_of_impact(sweep_a, sweep_b, 0, 1, margin / 2).time;
  if (!(time <= 1)) return 0;
  PairCache cache;
  const int count = narrow.collide(*c.shape[a], sweep_a.at(time), *c.shape[b], sweep_b.at(time), margin, cache, found);
  ahead = time * (sweep_b.shift - sweep_a.shift);
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < found[n].count; ++k) {
      ManifoldPoint& q = found[n].points[k];
      q.position -= time * sweep_a.shift;
      const Vec3 arm_a = q.position - c.center[a], arm_b = q.position - c.center[b] - ahead;
      const Vec3 nearer = ahead + time * (cross(sweep_b.turn, arm_b) - cross(sweep_a.turn, arm_a));
      q.separation -= std::min(dot(nearer, found[n].normal), Real(0));
    }
  return count;
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
  if (!c.shape[a]->convex()) return {};
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
