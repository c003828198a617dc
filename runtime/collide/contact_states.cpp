// Contact states: which contacts count as contact in the contact book (per pair of objects; sensors: per net point).
// A contact begins when a point is closer than kContactBegin of the margin, or took an impulse in this step (a
// speculative point that stopped a body); it ends when all points are farther than kContactEnd and none took an
// impulse. The hysteresis keeps resting contacts from flickering. Impulses are known after the solve, so contacts that
// depend on them are checked in the last pass.
// Changes go to the contact book, which sums them per pair of objects: a contact that ends (forget) and begins again
// before the step's end cancels out.
// Weak spot: a pair in contact at one point that hits at a second one reports no hit.
#include <algorithm>

#include "collide/impl.h"

namespace feder {

std::uint32_t Collide::Impl::net_point(const ContactEntry& e) const {
  const Colliders& c = *colliders;
  if (c.owner[e.a] == ColliderOwner::point) return c.sub[e.a];
  return c.owner[e.b] == ColliderOwner::point ? c.sub[e.b] : 0;
}

ContactKey Collide::Impl::key(const ContactEntry& e, bool& flipped) const {
  const Colliders& c = *colliders;
  const ObjectId a = c.object[e.a], b = c.object[e.b];
  const bool sensor = (e.bits & kSensorPair) != 0;
  flipped = sensor ? (e.bits & kSensorIsB) != 0 : b < a;
  return {flipped ? b : a, flipped ? a : b, sensor ? net_point(e) : 0, sensor ? 1u : 0u};
}

// The deepest point of a contact, and its impulse and speed in this step.
ContactFinding Collide::Impl::finding(const ContactEntry& e) const {
  ContactFinding n;
  bool flipped;
  n.key = key(e, flipped);
  n.index = net_point(e);
  if (e.slot == kNone) return n;
  const Contact& contact = contacts->slots[e.slot];
  Real deepest = kInfinity;
  for (int k = 0; k < contact.point_count; ++k) {
    const ContactPoint& p = contact.points[k];
    n.impulse += p.total_impulse;
    n.speed = std::max(n.speed, -p.approach_speed);
    if (!(p.separation < deepest)) continue;
    deepest = p.separation;
    n.point = colliders->center[e.a] + p.arm_a;
  }
  n.normal = flipped ? Vec3(-contact.normal) : contact.normal;
  return n;
}

void Collide::Impl::count(const ContactEntry& e, int change) {
  FEDER_ASSERT(((e.bits & kReported) != 0) == (change < 0));
  ContactFinding n = finding(e);
  n.change = change;
  book->count(n);
}

void Collide::Impl::check_watched() {
  for (const std::uint32_t i : watched) {
    FEDER_ASSERT(i < entries.size() && (entries[i].bits & kWatch));
    ContactEntry& e = entries[i];
    const bool reported = e.bits & kReported;
    const Real margin = memory[e.pair].margin;
    Real nearest = kInfinity, impulse = 0;
    for (int k = 0; e.slot != kNone && k < contacts->slots[e.slot].point_count; ++k) {
      const ContactPoint& p = contacts->slots[e.slot].points[k];
      nearest = std::min(nearest, p.separation);
      impulse += p.total_impulse;
    }
    // reported contacts are watched only when farther than kContactEnd
    const bool in_contact = (!reported && nearest <= kContactBegin * margin) || impulse > 0;
    if (in_contact == reported) continue;
    count(e, in_contact ? 1 : -1);
    e.bits ^= kReported;
  }
}

// contact_stay: reported contacts that were tested in this step.
void Collide::Impl::report_stay() {
  for (const ContactEntry& e : entries) {
    if ((e.bits & (kTested | kReported | kSensorPair)) != (kTested | kReported)) continue;
    if (e.slot == kNone || (!colliders->awake[e.a] && !colliders->awake[e.b])) continue;
    const Contact& contact = contacts->slots[e.slot];
    ContactFinding n = finding(e);
    const Vec3 va =
        colliders->velocity[e.a] + cross(colliders->angular_velocity[e.a], n.point - colliders->center[e.a]);
    const Vec3 vb =
        colliders->velocity[e.b] + cross(colliders->angular_velocity[e.b], n.point - colliders->center[e.b]);
    const Vec3 slide = vb - va - contact.surface_velocity;
    n.slip = length(slide - contact.normal * dot(slide, contact.normal));
    book->stay(n);
  }
}

void Collide::Impl::report_contact_states(StepContext& c) {
  check_watched();
  watched.clear();
  if (c.events->wanted(EventKind::contact_stay)) report_stay();
}

}  // namespace feder
