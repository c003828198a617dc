// Events: begin and end per pair of objects (sensors: per net point), stay and hit when wanted.
// A contact touches once a point is closer than kTouchBegin of the margin, or took an impulse in this step (a
// speculative point that stopped a body); it ends when all points are farther than kTouchEnd and none took an
// impulse. The gap between the two keeps resting contacts from flickering. Impulses are known after the solve, so
// contacts that depend on them are judged here, in the last row. A hit is reported on the step its begin is.
// Changes wait as transitions and are summed per pair of objects in one sorted merge; what leaves (forget) and comes
// back before the merge cancels out. So begins and ends alternate whatever happens.
// Kept between calls: the number of touching contacts per pair of objects, sorted.
// Weak spot: a pair that touches in one place and hits in a second one reports no hit.
#include <algorithm>

#include "collide/impl.h"

namespace feder {

std::uint32_t Collide::Impl::net_point(const ContactEntry& e) const {
  const Colliders& c = *colliders;
  if (c.owner[e.a] == ObjectKind::net) return c.sub[e.a];
  return c.owner[e.b] == ObjectKind::net ? c.sub[e.b] : 0;
}

TouchKey Collide::Impl::key(const ContactEntry& e, bool& flipped) const {
  const Colliders& c = *colliders;
  const ObjectId a = c.object[e.a], b = c.object[e.b];
  const bool sensor = (e.bits & kSensorPair) != 0;
  flipped = sensor ? (e.bits & kSensorIsB) != 0 : b < a;
  return {flipped ? b : a, flipped ? a : b, sensor ? net_point(e) : 0, sensor ? 1u : 0u};
}

// A thing whose faces meet a body beside its points, which are colliders: one begin and one end for both.
void Collide::count_face(const Event& contact, int change) {
  Transition t;
  const bool flipped = contact.b < contact.a;
  t.key = {flipped ? contact.b : contact.a, flipped ? contact.a : contact.b, 0, 0};
  t.change = change;
  t.sequence = static_cast<std::uint32_t>(impl_->transitions.size());
  t.index = contact.index, t.face = 1;
  t.point = contact.point, t.normal = flipped ? Vec3(-contact.normal) : contact.normal;
  t.speed = contact.speed, t.impulse = contact.impulse;
  impl_->transitions.push_back(t);
}

void Collide::stay_face(const Event& contact) {
  Transition t;
  const bool flipped = contact.b < contact.a;
  t.key = {flipped ? contact.b : contact.a, flipped ? contact.a : contact.b, 0, 0};
  t.index = contact.index;
  t.point = contact.point, t.normal = flipped ? Vec3(-contact.normal) : contact.normal;
  t.speed = contact.slip, t.impulse = contact.impulse;
  impl_->face_stays.push_back(t);
}

void Collide::Impl::add_transition(const ContactEntry& e, int change) {
  FEDER_ASSERT(change == 1 || change == -1);
  FEDER_ASSERT(((e.bits & kReported) != 0) == (change < 0));
  Transition t;
  bool flipped;
  t.key = key(e, flipped);
  t.index = net_point(e);
  t.change = change;
  t.sequence = static_cast<std::uint32_t>(transitions.size());
  // where: the deepest point
  const Contact& contact = contacts->slots[e.slot];
  Real deepest = kInfinity;
  for (int k = 0; k < contact.point_count; ++k) {
    const ContactPoint& p = contact.points[k];
    t.impulse += p.total_impulse;
    t.speed = std::max(t.speed, -p.approach_speed);
    if (!(p.separation < deepest)) continue;
    deepest = p.separation;
    t.point = colliders->center[e.a] + p.arm_a;
  }
  t.normal = flipped ? Vec3(-contact.normal) : contact.normal;
  transitions.push_back(t);
}

void Collide::Impl::judge_watched() {
  for (const std::uint32_t i : watched) {
    FEDER_ASSERT(i < entries.size() && (entries[i].bits & kWatch));
    ContactEntry& e = entries[i];
    const Contact& contact = contacts->slots[e.slot];
    const bool reported = e.bits & kReported;
    const Real margin = memory[entries[i - e.sub].slot].margin;
    Real nearest = kInfinity, impulse = 0;
    for (int k = 0; k < contact.point_count; ++k) {
      nearest = std::min(nearest, contact.points[k].separation);
      impulse += contact.points[k].total_impulse;
    }
    // a reported one is watched only when it is farther than kTouchEnd
    const bool touches_now = (!reported && nearest <= kTouchBegin * margin) || impulse > 0;
    if (touches_now == reported) continue;
    add_transition(e, touches_now ? 1 : -1);
    e.bits ^= kReported;
  }
}

// Sums per pair of objects over the contacts that were tested in this step, for pairs that touched before it.
void Collide::Impl::report_stay(StepContext& c) {
  stays.swap(face_stays);
  face_stays.clear();
  for (std::size_t k = 0; k < stays.size(); ++k) stays[k].sequence = static_cast<std::uint32_t>(k);
  for (const ContactEntry& e : entries) {
    if ((e.bits & (kTested | kReported | kSensorPair)) != (kTested | kReported)) continue;
    const Contact& contact = contacts->slots[e.slot];
    if (contact.point_count == 0 || (!colliders->awake[e.a] && !colliders->awake[e.b])) continue;
    Transition t;
    bool flipped;
    t.key = key(e, flipped);
    t.index = net_point(e);
    t.sequence = static_cast<std::uint32_t>(stays.size());
    const ContactPoint* deepest = &contact.points[0];
    for (int k = 0; k < contact.point_count; ++k) {
      t.impulse += contact.points[k].total_impulse;
      if (contact.points[k].separation < deepest->separation) deepest = &contact.points[k];
    }
    const Vec3 va = colliders->velocity[e.a] + cross(colliders->angular_velocity[e.a], deepest->arm_a);
    const Vec3 vb = colliders->velocity[e.b] + cross(colliders->angular_velocity[e.b], deepest->arm_b);
    const Vec3 slide = vb - va - contact.surface_velocity;
    t.speed = length(slide - contact.normal * dot(slide, contact.normal));
    t.point = colliders->center[e.a] + deepest->arm_a;
    t.normal = flipped ? Vec3(-contact.normal) : contact.normal;
    stays.push_back(t);
  }
  std::sort(stays.begin(), stays.end(), [](const Transition& x, const Transition& y) {
    return std::tie(x.key, x.sequence) < std::tie(y.key, y.sequence);
  });
  std::size_t touch = 0;
  for (std::size_t first = 0, last; first < stays.size(); first = last) {
    Transition& sum = stays[first];
    for (last = first + 1; last < stays.size() && stays[last].key == sum.key; ++last) {
      sum.impulse += stays[last].impulse;
      sum.speed = std::max(sum.speed, stays[last].speed);
    }
    while (touch < touches.size() && touches[touch].key < sum.key) ++touch;
    if (touch == touches.size()) break;
    if (touches[touch].key != sum.key || touches[touch].begun == c.step) continue;
    Event event;
    event.kind = EventKind::contact_stay;
    event.a = sum.key.a, event.b = sum.key.b, event.index = sum.index;
    event.point = sum.point, event.normal = sum.normal;
    event.impulse = sum.impulse, event.slip = sum.speed;
    c.events->add(event);
  }
}

void Collide::Impl::merge_transitions(StepContext& c) {
  if (transitions.empty()) return;
  std::sort(transitions.begin(), transitions.end(), [](const Transition& x, const Transition& y) {
    return std::tie(x.key, x.sequence) < std::tie(y.key, y.sequence);
  });
  next_touches.clear();
  std::size_t n = 0;
  for (std::size_t first = 0, last; first < transitions.size(); first = last) {
    const TouchKey& pair = transitions[first].key;
    int change = 0, faces = 0;
    for (last = first; last < transitions.size() && transitions[last].key == pair; ++last) {
      change += transitions[last].change;
      if (transitions[last].face) faces += transitions[last].change;
    }
    while (n < touches.size() && touches[n].key < pair) next_touches.push_back(touches[n++]);
    Touch touch{pair, 0, 0, c.step};
    if (n < touches.size() && touches[n].key == pair) touch = touches[n++];
    const std::uint32_t before = touch.count;
    FEDER_ASSERT(static_cast<int>(before) + change >= 0);
    touch.count = static_cast<std::uint32_t>(static_cast<int>(before) + change);
    touch.faces = static_cast<std::uint32_t>(static_cast<int>(touch.faces) + faces);
    if (touch.count) next_touches.push_back(touch);
    if ((before == 0) != (touch.count == 0)) report(c, touch.count != 0, first, last);
  }
  next_touches.insert(next_touches.end(), touches.begin() + static_cast<std::ptrdiff_t>(n), touches.end());
  touches.swap(next_touches);
  next_touches.reserve(touches.capacity());
  transitions.clear();
}

// The pair of transitions [first, last) began or ended to touch.
void Collide::Impl::report(StepContext& c, bool began, std::size_t first, std::size_t last) {
  const Transition& t = transitions[first];
  Event event;
  event.a = t.key.a, event.b = t.key.b, event.index = t.key.sensor ? t.key.index : t.index;
  if (t.key.sensor) {
    event.kind = began ? EventKind::sensor_enter : EventKind::sensor_leave;
    c.events->add(event);
    return;
  }
  event.kind = began ? EventKind::contact_begin : EventKind::contact_end;
  event.point = t.point, event.normal = t.normal;
  c.events->add(event);
  if (!began || !c.events->wanted(EventKind::hit)) return;
  event.kind = EventKind::hit;
  for (std::size_t i = first; i < last; ++i) {
    if (transitions[i].change < 0) continue;
    event.impulse += transitions[i].impulse;
    event.speed = std::max(event.speed, transitions[i].speed);
  }
  if (event.speed >= kSlowestHit) c.events->add(event);
}

void Collide::Impl::report_touches(StepContext& c) {
  judge_watched();
  watched.clear();
  merge_transitions(c);
  if (c.events->wanted(EventKind::contact_stay)) report_stay(c);
  face_stays.clear();
}

}  // namespace feder
