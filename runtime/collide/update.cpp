// Narrow tests of all contacts with a side that may have moved, in parallel: each contact writes its own slot only.
// Serial passes in order then list arriving contacts, for waking, and the active contacts. Contact recycling
// (Catto, Box3D 2026): most contacts of a pile are tested again although nothing moved. While the relative motion since
// the last real test is tiny, normal, arms and features stay and only the separations follow: base + relative
// displacement along the normal, to first order in the rotations. The base is always that of the real test, so errors
// do not add up over steps. Kept between calls: per contact the poses and separations of its last real test. Points of
// a new manifold take the impulses of the old points with the same feature, else of the nearest. Weak spot: a pair that
// rotates together (in a drum) is tested again every few steps.
#include "base/jobs.h"
#include "base/prefetch.h"
#include "collide/impl.h"

namespace feder {
namespace {

// Rotation vector from `from` to `to`, right to first order: recycled angles are below kRecycleAngle.
Vec3 small_rotation(const Quat& from, const Quat& to) {
  const Quat d = to * conjugate(from);
  const Real twice = d.w < 0 ? Real(-2) : Real(2);
  return twice * d.vec();
}

// The rotation that two bodies share, axis by axis: none where one of them does not rotate or the signs differ.
Vec3 common_rotation(const Vec3& a, const Vec3& b) {
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (a[k] * b[k] > 0) out[k] = std::fabs(a[k]) < std::fabs(b[k]) ? a[k] : b[k];
  return out;
}

// Friction is carried over as a vector when the normal, and the tangents with it, rotate.
void carry_friction(const Contact& from, Contact& to) {
  Vec3 s1, s2, t1, t2;
  tangent_frame(from.normal, s1, s2);
  tangent_frame(to.normal, t1, t2);
  const Vec3 friction = s1 * from.tangent_impulse[0] + s2 * from.tangent_impulse[1];
  to.tangent_impulse[0] = dot(friction, t1), to.tangent_impulse[1] = dot(friction, t2);
}

// `base` rotated by `rotation`, right to second order.
void rotate_normal(Contact& contact, const Vec3& base, const Vec3& rotation) {
  const Contact before = contact;
  contact.normal = normalized_or(base + cross(rotation, base), base);
  carry_friction(before, contact);
}

bool same(const Quat& p, const Quat& q) { return p.x == q.x && p.y == q.y && p.z == q.z && p.w == q.w; }

// The contacts of a pair that had points.
struct OldContacts {
  OldContacts() {}
  std::size_t count = 0;
  union {  // not filled before use
    Contact contact[kMaxManifolds];
  };
};

// The old point that a new one continues: same feature, else the nearest unused one within `limit`.
const ContactPoint* old_point(const ContactPoint& p, std::span<const Contact> old, Real limit, std::uint32_t& used) {
  const ContactPoint* nearest = nullptr;
  Real best = limit * limit;
  std::uint32_t best_bit = 0, bit = 1;
  for (const Contact& contact : old) {
    for (int k = 0; k < contact.point_count; ++k, bit <<= 1) {
      if (used & bit) continue;
      const ContactPoint& q = contact.points[k];
      if (q.feature == p.feature) return used |= bit, &q;
      // arms are in world axes: the smaller difference is that of the body that rotated less
      const Vec3 da = p.arm_a - q.arm_a, db = p.arm_b - q.arm_b;
      const Real distance = std::min(dot(da, da), dot(db, db));
      if (distance < best) best = distance, nearest = &q, best_bit = bit;
    }
  }
  used |= best_bit;
  return nearest;
}

}  // namespace

// Slots lie in no order of the entries: what is tested soon is on its way to the cache meanwhile. Inline always: a call
// of a function that has no effect but this is left out by compilers.
[[gnu::always_inline]] inline void Collide::Impl::fetch(const ContactEntry& e) const {
  if (e.sub == 0) prefetch(memory[e.pair]);
}

void Collide::Impl::collide(StepContext& c) {
  bool changed = merge_pairs();
  const std::uint32_t count = static_cast<std::uint32_t>(entries.size());
  constexpr std::uint32_t kAhead = 8;     // pairs with a mesh or a field have several entries each
  constexpr JobGrain kGrain{64, 10'000};  // contacts; a third of that when all are recycled
  while (found_by.size() < static_cast<std::size_t>(c.jobs->threads()))
    found_by.emplace_back(&arena), found_by_slack.emplace_back();
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int worker) {
    for (std::uint32_t i = first; i < last; ++i) {
      if (i + kAhead < count) fetch(entries[i + kAhead]);
      if (entries[i].sub == 0) test_pair(i, c.dt, found_by[static_cast<std::size_t>(worker)]);
    }
  });
  changed |= take_slots();
  leave_out_ghosts(c);
  changed |= free_slots();
  if (changed) write_order();
  list_arrivals();
}

// Contacts that have their first points get slots.
bool Collide::Impl::take_slots() {
  found_in_order.clear();
  for (const Array<NewContact>& found : found_by)
    for (const NewContact& f : found) found_in_order.push_back(&f);
  std::sort(found_in_order.begin(), found_in_order.end(),
            [](const NewContact* x, const NewContact* y) { return x->entry < y->entry; });
  for (const NewContact* f : found_in_order) {
    const std::uint32_t slot = take_index(contacts->free_list, contacts->slots.size(), [&] {
      contacts->slots.emplace_back();
      bases.emplace_back();
    });
    FEDER_ASSERT(contacts->slots[slot].collider_a == kNone && entries[f->entry].slot == kNone);  // free until now
    contacts->slots[slot] = f->contact;
    bases[slot] = f->base;
    entries[f->entry].slot = slot;
  }
  const bool any = !found_in_order.empty();
  found_slack.clear(found_in_order);
  for (std::size_t i = 0; i < found_by.size(); ++i) found_by_slack[i].clear(found_by[i]);
  return any;
}

// Contacts that have lost their points give them back.
bool Collide::Impl::free_slots() {
  bool any = false;
  for (ContactEntry& e : entries) {
    if (e.slot == kNone || (e.bits & kTouching)) continue;
    free_slot(e.slot);
    e.slot = kNone;
    any = true;
  }
  return any;
}

void Collide::Impl::test_pair(std::uint32_t head, Real dt, Array<NewContact>& found) {
  constexpr std::uint16_t kOfStep = kTested | kWatch | kArrived;
  const Colliders& c = *colliders;
  const std::uint32_t count = entries_of_pair(entries[head].bits);
  FEDER_ASSERT(head + count <= entries.size() && entries[head + count - 1].a == entries[head].a &&
               entries[head + count - 1].sub == count - 1);
  const std::span<ContactEntry> group(&entries[head], count);
  const std::uint32_t a = group[0].a, b = group[0].b;
  const bool is_new = group[0].bits & kNew;
  for (ContactEntry& e : group) e.bits &= static_cast<std::uint16_t>(~(kOfStep | kNew));
  const std::uint32_t seen_bits = seen[a].bits | seen[b].bits;
  if (group[0].bits & kSensorPair) return test_sensor(group[0]);
  FEDER_ASSERT(is_new || c.awake[a] || c.awake[b] || (seen_bits & (kChanged | kSettled)));  // else it rests
  // shapes or filters changed: margins anew
  PairMemory& m = memory[group[0].pair];
  if (seen_bits & kChanged) {
    m.valid = 0;
    for (const ContactEntry& e : group)
      if (starts_number(e)) measure(memory[e.pair], a, b);
  }
  const bool ahead = !(group[0].bits & kTouching) && may_pass(a, b, dt);
  std::size_t next = found.size();
  const std::uint32_t written = !ahead && recycle(group) ? 0 : test_fresh(group, m.margin, dt, found);
  for (std::size_t k = 0; k < group.size(); ++k) {
    ContactEntry& e = group[k];
    if (!(e.bits & kTouching) && !(written >> k & 1u)) {
      stay_apart(e);
      continue;
    }
    if (e.slot == kNone) found[next].entry = head + static_cast<std::uint32_t>(k);
    Contact& contact = e.slot == kNone ? found[next++].contact : contacts->slots[e.slot];
    if (contact.fresh || (seen_bits & (kSurfaceChanged | kConveyor))) mix(contact);
    check_contact(e, contact, m.margin, dt);
  }
}

// Sensors are exact: only a pair that did not move at all keeps its answer.
void Collide::Impl::test_sensor(ContactEntry& e) {
  const Colliders& c = *colliders;
  PairMemory& m = memory[e.pair];
  const Vec3 between = c.center[e.b] - c.center[e.a];
  const Quat &ra = c.pose[e.a].rotation, &rb = c.pose[e.b].rotation;
  const bool changed = (seen[e.a].bits | seen[e.b].bits) & kChanged;
  e.bits |= kTested;
  if (m.valid && !changed && between == m.between && same(ra, m.rotation_a) && same(rb, m.rotation_b)) return;
  m.valid = 1;
  m.between = between;
  m.rotation_a = ra, m.rotation_b = rb;
  const bool hit = shapes_overlap(narrow, *c.shape[e.a], c.pose[e.a], *c.shape[e.b], c.pose[e.b]);
  e.bits = static_cast<std::uint16_t>(hit ? e.bits | kTouching : e.bits & ~kTouching);
}

// Recycling; false when the pair moved too far since its last real test.
bool Collide::Impl::recycle(std::span<const ContactEntry> group) {
  const Colliders& c = *colliders;
  const PairMemory& m = memory[group[0].pair];
  if (!m.valid) return false;
  const std::uint32_t a = group[0].a, b = group[0].b;
  const Vec3 rotation_a = small_rotation(m.rotation_a, c.pose[a].rotation);
  const Vec3 rotation_b = small_rotation(m.rotation_b, c.pose[b].rotation);
  constexpr Real limit = kRecycleAngle * kRecycleAngle;
  if (!(dot(rotation_a, rotation_a) < limit && dot(rotation_b, rotation_b) < limit)) return false;
  // relative displacement at the centre of the smaller one, and that by relative rotation at its farthest point
  const Vec3 between = c.center[b] - c.center[a];
  const Vec3 apart = between - m.between;
  const Vec3 shift = m.about_a ? Vec3(apart - cross(rotation_b, between)) : Vec3(apart - cross(rotation_a, between));
  const Real drift = length(shift) + length(rotation_b - rotation_a) * m.extent;
  const Real limit_of_drift = group[0].bits & kFieldPair ? kRecycleOnField : kRecycleDistance;
  if (!(drift < limit_of_drift * m.margin)) return false;

  // separations, and normals rotated along
  const Vec3 common = common_rotation(rotation_a, rotation_b);
  const bool rotated = dot(common, common) > kRotateNormal * kRotateNormal;
  for (const ContactEntry& e : group) {
    if (!(e.bits & kTouching)) continue;
    Contact& contact = contacts->slots[e.slot];
    const ContactBase& base = bases[e.slot];
    contact.fresh = 0;
    if (rotated) rotate_normal(contact, base.normal, common);
    for (int k = 0; k < contact.point_count; ++k) {
      ContactPoint& p = contact.points[k];
      const Vec3 slip = apart + cross(rotation_b, p.arm_b) - cross(rotation_a, p.arm_a);
      p.separation = base.separation[k] + dot(slip, contact.normal);
      p.total_impulse = 0;
    }
  }
  return true;
}

// Returns a bit per contact that has points, or had. Those without a slot are appended to `found_new`.
std::uint32_t Collide::Impl::test_fresh(std::span<const ContactEntry> group, Real margin, Real dt,
                                        Array<NewContact>& found_new) {
  const Colliders& c = *colliders;
  PairMemory& m = memory[group[0].pair];
  const std::uint32_t a = group[0].a, b = group[0].b;
  Manifold found[kMaxManifolds];
  Vec3 ahead = Vec3::Zero();
  int count = group[0].bits & kFieldPair
                  ? collide_midway(a, b, margin, dt, m.cache, found, ahead)
                  : narrow.collide(*c.shape[a], c.pose[a], *c.shape[b], c.pose[b], margin, m.cache, found);
  FEDER_ASSERT(count >= 0 && static_cast<std::size_t>(count) <= group.size());
  m.valid = 1;
  if (count == 0 && may_pass(a, b, dt)) {
    count = look_ahead(a, b, margin, dt, found, ahead);
    m.valid = count == 0;
  }
  m.between = c.center[b] - c.center[a];
  m.rotation_a = c.pose[a].rotation, m.rotation_b = c.pose[b].rotation;
  OldContacts old;
  for (const ContactEntry& e : group)
    if (e.bits & kTouching) old.contact[old.count++] = contacts->slots[e.slot];
  std::uint32_t written = 0;
  for (std::size_t k = 0; k < group.size(); ++k) {
    const bool used = static_cast<int>(k) < count;
    const ContactEntry& e = group[k];
    if (!used && e.slot == kNone) continue;
    written |= 1u << k;
    if (e.slot == kNone) found_new.emplace_back();
    Contact& contact = e.slot == kNone ? found_new.back().contact : contacts->slots[e.slot];
    contact.collider_a = a, contact.collider_b = b, contact.sub = e.sub;
    ContactBase& base = e.slot == kNone ? found_new.back().base : bases[e.slot];
    static const Manifold none;
    // matching limit: a tenth of the smaller shape
    write_manifold(contact, base, used ? found[k] : none, {old.contact, old.count}, m.extent / 10, ahead);
  }
  return written;
}

// `ahead`: how far b's centre comes nearer until the manifold, zero when it is that of now.
void Collide::Impl::write_manifold(Contact& contact, ContactBase& base, const Manifold& m, std::span<const Contact> old,
                                   Real limit, const Vec3& ahead) {
  const Vec3 &center_a = colliders->center[contact.collider_a], &center_b = colliders->center[contact.collider_b];
  FEDER_ASSERT(m.count >= 0 && m.count <= kMaxContactPoints);
  // wide: normals across distances whose squares underflow are rough, and overflow leaves none of huge shapes
  FEDER_ASSERT(m.count == 0 || m.normal.isZero(0) || !(std::fabs(length(m.normal) - 1) > Real(0.5)));
  // a new manifold
  contact.fresh = 1;
  contact.point_count = static_cast<std::uint8_t>(m.count);
  contact.surface = m.surface;
  contact.normal = base.normal = m.normal;
  contact.tangent_impulse[0] = contact.tangent_impulse[1] = contact.twist_impulse = 0;
  contact.rolling_impulse = Vec3::Zero();
  // its points, with the impulses of old ones
  const Contact* ancestor = nullptr;
  std::uint32_t used = 0;
  for (int k = 0; k < kMaxContactPoints; ++k) {
    ContactPoint& p = contact.points[k];
    p = {};
    base.separation[k] = 0;
    if (k >= m.count) continue;
    const ManifoldPoint& q = m.points[k];
    p.arm_a = q.position - center_a, p.arm_b = q.position - center_b - ahead;
    p.separation = base.separation[k] = q.separation;
    p.feature = q.feature;
    const ContactPoint* from = old_point(p, old, limit, used);
    if (!from) continue;
    p.normal_impulse = from->normal_impulse;
    for (const Contact& o : old)
      if (!ancestor && from >= o.points && from < o.points + kMaxContactPoints) ancestor = &o;
  }
  // friction, of the manifold that they came from
  if (!ancestor) return;
  carry_friction(*ancestor, contact);
  contact.twist_impulse = ancestor->twist_impulse;
  contact.rolling_impulse = ancestor->rolling_impulse;
}

// The surface of one collider at a contact.
struct Collide::Impl::Side {
  SurfaceNumbers numbers;
  std::uint16_t material = 0;
  Vec3 velocity = Vec3::Zero();  // in the owner's frame, m/s
};

// On a mesh: what the triangles state, then their material, then the collider.
Collide::Impl::Side Collide::Impl::side_of(const Contact& contact, std::uint32_t i) const {
  const Colliders& c = *colliders;
  Side side{{c.friction_static[i], c.friction_dynamic[i], c.restitution[i], c.rolling_friction[i]},
            c.material[i],
            c.surface_velocity[i]};
  if (contact.surface == 0) return side;
  const std::span<const ShapeSurface> list = c.shape[i]->surfaces();
  if (list.empty()) return side;
  FEDER_ASSERT(contact.surface <= list.size());
  const ShapeSurface& own = list[contact.surface - 1];
  if (!own.material.empty()) {
    const auto it = std::find(materials.begin(), materials.end(), own.material);
    const auto at = static_cast<std::size_t>(it - materials.begin());
    if (it != materials.end()) side.material = static_cast<std::uint16_t>(at + 1);
    if (at < material_numbers.size()) override_numbers(side.numbers, material_numbers[at]);
  }
  override_numbers(side.numbers, own.numbers);
  if (own.has_velocity) side.velocity = own.velocity;
  return side;
}

// Friction: geometric mean, so that ice makes any pair slippery. Restitution and rolling friction: the larger, so
// that a ball bounces (a soft one rolls badly) on any floor. A material pair overrides what it states.
void Collide::Impl::mix(Contact& contact) const {
  const Colliders& c = *colliders;
  const std::uint32_t a = contact.collider_a, b = contact.collider_b;
  const Side on_a = side_of(contact, a), on_b = side_of(contact, b);
  const SurfaceNumbers &p = on_a.numbers, &q = on_b.numbers;
  FEDER_ASSERT(p.friction_static >= 0 && p.friction_dynamic >= 0 && p.restitution >= 0);
  contact.friction_static = std::sqrt(p.friction_static * q.friction_static);
  contact.friction_dynamic = std::sqrt(p.friction_dynamic * q.friction_dynamic);
  contact.restitution = std::max(p.restitution, q.restitution);
  contact.rolling_friction = std::max(p.rolling_friction, q.rolling_friction);
  const std::uint16_t low = std::min(on_a.material, on_b.material), high = std::max(on_a.material, on_b.material);
  for (const MaterialPair& pair : material_pairs) {
    if (pair.a != low || pair.b != high) continue;
    if (pair.friction_static >= 0) contact.friction_static = pair.friction_static;
    if (pair.friction_dynamic >= 0) contact.friction_dynamic = pair.friction_dynamic;
    if (pair.restitution >= 0) contact.restitution = pair.restitution;
  }
  contact.surface_velocity = Vec3::Zero();
  if (!((seen[a].bits | seen[b].bits) & kConveyor)) return;
  // a belt on a carries b along, one on b pushes it back
  const auto belt = [&](std::uint32_t i, const Vec3& velocity) {
    return rotate(c.pose[i].rotation * conjugate(c.local[i].rotation), velocity);
  };
  const Vec3 wanted = belt(a, on_a.velocity) - belt(b, on_b.velocity);
  contact.surface_velocity = wanted - contact.normal * dot(wanted, contact.normal);
}

// Approach speeds, and the bits for waking and events (contact_states.cpp has the rule of contact states).
void Collide::Impl::check_contact(ContactEntry& e, Contact& contact, Real margin, Real dt) {
  const Colliders& c = *colliders;
  const Vec3 between = c.velocity[e.b] - c.velocity[e.a];
  const Vec3 angular_a = c.angular_velocity[e.a], angular_b = c.angular_velocity[e.b];
  Real nearest = kInfinity, predicted = kInfinity;
  for (int k = 0; k < contact.point_count; ++k) {
    ContactPoint& p = contact.points[k];
    p.approach_speed = dot(between + cross(angular_b, p.arm_b) - cross(angular_a, p.arm_a), contact.normal);
    nearest = std::min(nearest, p.separation);
    predicted = std::min(predicted, p.separation + std::min(p.approach_speed, Real(0)) * dt);
  }
  contact.touching = contact.point_count > 0;
  const bool reported = e.bits & kReported, was_near = e.bits & kNear;
  const bool near = predicted <= (was_near ? kContactEnd : kContactBegin) * margin;
  const bool watch = reported ? !(nearest <= kContactEnd * margin) : contact.touching != 0;
  int bits = e.bits & ~(kTouching | kNear);
  bits |= kTested | (contact.touching ? kTouching : 0) | (near ? kNear : 0);
  bits |= (near && !was_near ? kArrived : 0) | (watch ? kWatch : 0);
  e.bits = static_cast<std::uint16_t>(bits);
}

// As check_contact of a contact without points.
void Collide::Impl::stay_apart(ContactEntry& e) {
  const int bits = e.bits & ~(kTouching | kNear);
  e.bits = static_cast<std::uint16_t>(bits | kTested | (bits & kReported ? kWatch : 0));
}

void Collide::Impl::list_arrivals() {
  watched.clear();
  contacts->arrivals.clear();
  for (std::uint32_t i = 0; i < entries.size(); ++i) {
    ContactEntry& e = entries[i];
    if (!(e.bits & kTested)) continue;
    FEDER_ASSERT(!(e.bits & kNew));
    if (e.bits & kSensorPair) {
      const bool inside = e.bits & kTouching, reported = e.bits & kReported;
      if (inside != reported) count(e, inside ? 1 : -1), e.bits ^= kReported;
      continue;
    }
    if (e.bits & kWatch) watched.push_back(i);
    if (e.bits & kArrived) contacts->arrivals.push_back({e.a, e.b});
  }
}

// After all wakes, so that the contacts of a woken island are solved in this step.
void Collide::Impl::list_active(StepContext&) {
  const Colliders& c = *colliders;
  const auto movable = [&](std::uint32_t n) { return c.motion[n] == ColliderMotion::dynamic && c.awake[n]; };
  return_woken();
  contacts->active.clear(), contacts->active_pairs.clear();
  for (const ContactEntry& e : entries) {
    if ((e.bits & (kTouching | kSensorPair)) != kTouching) continue;
    if (!movable(e.a) && !movable(e.b)) continue;
    contacts->active.push_back(e.slot);
    contacts->active_pairs.push_back({e.a, e.b});
    if (e.bits & kTested) continue;
    Contact& woken = contacts->slots[e.slot];
    woken.fresh = 0;
    for (ContactPoint& p : woken.points) p.total_impulse = p.approach_speed = 0;
  }
}

}  // namespace feder
