// Queries between steps: every collider's box, then its shape, in index order, so that ties fall to the lower index.
// A linear scan over boxes: an owner may have moved any of them since the broad phase last saw them, and has placed
// them anew (Rank::query_colliders).
#include <algorithm>

#include "bounds/segment_box.h"
#include "collide/impl.h"

namespace feder {
namespace {

bool nearer(const RaycastHit& x, const RaycastHit& y) {
  return x.fraction < y.fraction || (x.fraction == y.fraction && x.collider < y.collider);
}

}  // namespace

bool Collide::Impl::passes(std::uint32_t i, const QueryFilter& f) const {
  const Colliders& c = *colliders;
  if (c.motion[i] == ColliderMotion::none) return false;
  FEDER_ASSERT(c.shape[i]);
  if (c.sensor[i] && !f.sensors) return false;
  if (f.ignore && c.object[i] == f.ignore) return false;
  return (f.group & c.mask[i]) && (c.group[i] & f.mask);
}

void Collide::raycast_all(const Vec3& origin, const Vec3& ray, const QueryFilter& filter,
                          std::vector<RaycastHit>& hits) {
  const Colliders& c = *impl_->colliders;
  hits.clear();
  for (std::uint32_t i = 0; i < c.size(); ++i) {
    if (!impl_->passes(i, filter) || !segment_hits(c.box[i], origin, ray)) continue;
    RayHit hit;
    if (!c.shape[i]->raycast(to_local(c.pose[i], origin), rotate_inverse(c.pose[i].rotation, ray), hit)) continue;
    hits.push_back({i, c.object[i], origin + ray * hit.fraction, rotate(c.pose[i].rotation, hit.normal), hit.fraction});
  }
  std::sort(hits.begin(), hits.end(), nearer);
}

bool Collide::raycast(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, RaycastHit& hit) {
  const Colliders& c = *impl_->colliders;
  bool found = false;
  for (std::uint32_t i = 0; i < c.size(); ++i) {
    if (!impl_->passes(i, filter) || !segment_hits(c.box[i], origin, ray)) continue;
    RayHit local;
    if (!c.shape[i]->raycast(to_local(c.pose[i], origin), rotate_inverse(c.pose[i].rotation, ray), local)) continue;
    if (found && !(local.fraction < hit.fraction)) continue;
    found = true;
    hit = {i, c.object[i], origin + ray * local.fraction, rotate(c.pose[i].rotation, local.normal), local.fraction};
  }
  return found;
}

bool Collide::shape_cast(const Shape& shape, const Pose& pose, const Vec3& motion, const QueryFilter& filter,
                         RaycastHit& hit) {
  const Colliders& c = *impl_->colliders;
  bool found = false;
  Aabb swept = shape.bounds(pose);
  swept.include(Aabb{swept.lo + motion, swept.hi + motion});
  for (std::uint32_t i = 0; i < c.size(); ++i) {
    if (!impl_->passes(i, filter) || !overlaps(c.box[i], swept)) continue;
    CastHit cast;
    if (!feder::shape_cast(shape, pose, motion, *c.shape[i], c.pose[i], cast)) continue;
    if (found && !(cast.fraction < hit.fraction)) continue;
    found = true;
    hit = {i, c.object[i], cast.point, cast.normal, cast.fraction};
  }
  return found;
}

void Collide::overlap(const Shape& shape, const Pose& pose, const QueryFilter& filter, std::vector<ObjectId>& found) {
  const Colliders& c = *impl_->colliders;
  found.clear();
  const Aabb box = shape.bounds(pose);
  for (std::uint32_t i = 0; i < c.size(); ++i) {
    if (!impl_->passes(i, filter) || !overlaps(c.box[i], box)) continue;
    if (shapes_overlap(impl_->narrow, shape, pose, *c.shape[i], c.pose[i])) found.push_back(c.object[i]);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

Real Collide::max_penetration() const {
  Real deepest = 0;
  for (const ContactEntry& e : impl_->entries) {
    if ((e.bits & (kTouching | kSensorPair)) != kTouching) continue;
    const Contact& contact = impl_->contacts->slots[e.slot];
    for (int k = 0; k < contact.point_count; ++k) deepest = std::max(deepest, -contact.points[k].separation);
  }
  return deepest;
}

void Collide::contacts_of(ObjectId object, std::vector<ContactInfo>& out) const {
  out.clear();
  const Colliders& c = *impl_->colliders;
  for (const ContactEntry& e : impl_->entries) {
    const bool is_a = c.object[e.a] == object;
    if ((!is_a && c.object[e.b] != object) || (e.bits & (kReported | kSensorPair)) != kReported) continue;
    const Contact& contact = impl_->contacts->slots[e.slot];
    for (int k = 0; k < contact.point_count; ++k) {
      const ContactPoint& p = contact.points[k];
      out.push_back({c.object[is_a ? e.b : e.a], c.center[e.a] + p.arm_a, is_a ? contact.normal : Vec3(-contact.normal),
                     p.separation, p.total_impulse});
    }
  }
}

}  // namespace feder
