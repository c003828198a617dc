// What continuous collision asks: the colliders in the way of one, and when it meets them.
#include <algorithm>

#include "collide/impl.h"
#include "geom/width.h"
#include "narrow/impact.h"

namespace feder {

// A body stops this part of the margin before it touches: near enough to be in contact in the next step.
static constexpr Real kStopShort = Real(1) / 4;

Real Collide::core_depth(const Shape& shape) const {
  return shape.convex() ? (1 - kCoreScale) * least_half_width(shape) : kInfinity;
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
  const Sweep sweep_a{c.shape[a], c.local[a], motion_a.from, motion_a.shift, motion_a.turn, s.seen[a].extent};
  const Sweep sweep_b{c.shape[b], c.local[b], motion_b.from, motion_b.shift, motion_b.turn, s.seen[b].extent};
  const Impact hit = time_of_impact(sweep_a, sweep_b, begin, end, kStopShort * margin);
  return {hit.time, hit.normal, hit.point};
}

}  // namespace feder
