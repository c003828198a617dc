// Queries between steps: rays, swept shapes, overlaps, contacts of an object. A linear scan over boxes, then shapes, in
// index order, so that ties fall to the lower index: boxes may have moved since the broad phase was built, and have
// been placed anew (Rank::query_colliders). O(colliders) per query.
#include <algorithm>

#include "bounds/segment_box.h"
#include "collide/impl.h"

namespace feder {
namespace {

bool nearer(const RaycastHit& x, const RaycastHit& y) {
  return x.fraction < y.fraction || (x.fraction == y.fraction && x.collider < y.collider);
}

// Ties fall to the first.
void keep_nearest(const RaycastHit& next, RaycastHit& hit, bool& found) {
  if (!found || next.fraction < hit.fraction) hit = next;
  found = true;
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

// Calls f(collider) for those that pass the filter and whose box satisfies `near`.
template <class Near, class F>
void Collide::Impl::each_near(const QueryFilter& filter, Near&& near, F&& f) const {
  for (std::uint32_t i = 0; i < colliders->size(); ++i)
    if (passes(i, filter) && near(colliders->box[i])) f(i);
}

// Calls f(hit) for each collider that the ray hits.
template <class F>
void Collide::Impl::each_hit(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, F&& f) const {
  const Colliders& c = *colliders;
  each_near(
      filter, [&](const Aabb& box) { return segment_hits(box, origin, ray); },
      [&](std::uint32_t i) {
        RayHit hit;
        if (!c.shape[i]->raycast(to_local(c.pose[i], origin), rotate_inverse(c.pose[i].rotation, ray), hit)) return;
        f(RaycastHit{i, c.object[i], origin + ray * hit.fraction, rotate(c.pose[i].rotation, hit.normal),
                     hit.fraction});
      });
}

void Collide::raycast_all(const Vec3& origin, const Vec3& ray, const QueryFilter& filter,
                          std::vector<RaycastHit>& hits) {
  hits.clear();
  impl_->each_hit(origin, ray, filter, [&](const RaycastHit& hit) { hits.push_back(hit); });
  std::sort(hits.begin(), hits.end(), nearer);
}

bool Collide::raycast(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, RaycastHit& hit) {
  bool found = false;
  impl_->each_hit(origin, ray, filter, [&](const RaycastHit& next) { keep_nearest(next, hit, found); });
  return found;
}

bool Collide::shape_cast(const Shape& shape, const Pose& pose, const Vec3& motion, const QueryFilter& filter,
                         RaycastHit& hit) {
  const Colliders& c = *impl_->colliders;
  bool found = false;
  Aabb swept = shape.bounds(pose);
  swept.include(Aabb{swept.lo + motion, swept.hi + motion});
  impl_->each_near(
      filter, [&](const Aabb& box) { return overlaps(box, swept); },
      [&](std::uint32_t i) {
        CastHit cast;
        if (!feder::shape_cast(shape, pose, motion, *c.shape[i], c.pose[i], cast)) return;
        keep_nearest({i, c.object[i], cast.point, cast.normal, cast.fraction}, hit, found);
      });
  return found;
}

void Collide::overlap(const Shape& shape, const Pose& pose, const QueryFilter& filter, std::vector<ObjectId>& found) {
  const Colliders& c = *impl_->colliders;
  found.clear();
  const Aabb box = shape.bounds(pose);
  impl_->each_near(
      filter, [&](const Aabb& other) { return overlaps(other, box); },
      [&](std::uint32_t i) {
        if (shapes_overlap(impl_->narrow, shape, pose, *c.shape[i], c.pose[i])) found.push_back(c.object[i]);
      });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

Real Collide::max_penetration() const {
  Real deepest = 0;
  for (const Contact& contact : impl_->contacts->slots)  // free ones have no points
    for (int k = 0; k < contact.point_count; ++k) deepest = std::max(deepest, -contact.points[k].separation);
  return deepest;
}

void Collide::contacts_of(ObjectId object, std::vector<ContactInfo>& out) const {
  out.clear();
  const Colliders& c = *impl_->colliders;
  const std::vector<ContactEntry> own =
      impl_->listed_entries([&](const ContactEntry& e) { return c.object[e.a] == object || c.object[e.b] == object; });
  for (const ContactEntry& e : own) {
    if ((e.bits & (kReported | kSensorPair)) != kReported) continue;
    const bool is_a = c.object[e.a] == object;
    const Contact& contact = impl_->contacts->slots[e.slot];
    for (int k = 0; k < contact.point_count; ++k) {
      const ContactPoint& p = contact.points[k];
      out.push_back({c.object[is_a ? e.b : e.a], c.center[e.a] + p.arm_a, is_a ? contact.normal : Vec3(-contact.normal),
                     p.separation, p.total_impulse});
    }
  }
}

}  // namespace feder
