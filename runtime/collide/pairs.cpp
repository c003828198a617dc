// From boxes to the sorted list of contacts. The broad phase's sorted pairs are merged against the sorted contacts of
// the last step: in both = kept, only a pair = new, only a contact = gone. No hashing, and order is always defined.
// Kept between calls: the contacts, and what was known of each collider. Contacts between two colliders at rest, which
// the broad phase does not report, go to rest (resting.cpp). What lies still and was not changed is not looked at.
// Weak spot: pairs that filters reject are checked again in every step.
#include <algorithm>

#include "collide/impl.h"
#include "geom/width.h"

namespace feder {

// The colliders that may differ from the last step: those that counted as moving in it, and those in the lists of
// changes. Ascending, each once.
void Collide::Impl::list_examined() {
  Colliders& c = *colliders;
  const std::uint32_t count = c.size();
  changes.assign(c.changed.begin(), c.changed.end());
  changes.insert(changes.end(), c.touched.begin(), c.touched.end());
  c.changed.clear(), c.touched.clear();
  if (examine_all || recheck_surfaces) {
    examined.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) examined[i] = i;
    changes.assign(examined.begin(), examined.end());
    examine_all = false;
    return;
  }
  std::size_t kept = 0;
  for (const std::uint32_t i : examined)
    if (motion[i] == BoxMotion::moving) examined[kept++] = i;
  examined.resize(kept);
  if (changes.empty()) return;
  std::sort(changes.begin(), changes.end());
  changes.erase(std::unique(changes.begin(), changes.end()), changes.end());
  merged.resize(kept + changes.size());
  std::merge(examined.begin(), examined.end(), changes.begin(), changes.end(), merged.begin());
  merged.resize(static_cast<std::size_t>(std::unique(merged.begin(), merged.end()) - merged.begin()));
  examined.swap(merged);
}

// Finds what changed since the last step, and what the broad phase should treat as moving: awake colliders, and
// sensors, which detect sleeping bodies too. A changed collider counts as moving once, so that a fixed one put on top
// of a sleeping one is found; so does one that fell asleep, because it moved after its last test.
void Collide::Impl::compare_colliders() {
  const std::uint32_t count = colliders->size();
  if (motion.size() < count) motion.resize(count, BoxMotion::absent), seen.resize(count);
  for (const std::uint32_t i : examined) seen[i].bits &= kConveyor | kAwake;
  for (const std::uint32_t i : colliders->changed) {
    FEDER_ASSERT(i < count);
    seen[i].bits |= kChanged;
  }
  list_examined();
  for (const std::uint32_t i : changes) compare_collider(i);
  scenery_changed = false;
  for (const std::uint32_t i : examined) compare_motion(i);
  if (contacts->resting.count)
    for (const std::uint32_t i : examined) take_resting(i);
  if constexpr (kAsserts) check_unexamined();
  recheck_surfaces = false;
}

// Does a surface of it move?
bool Collide::Impl::is_conveyor(std::uint32_t i) const {
  const auto moves = [](const ShapeSurface& s) { return s.has_velocity && s.velocity != Vec3::Zero(); };
  const std::span<const ShapeSurface> own = colliders->shape[i]->surfaces();
  return colliders->surface_velocity[i] != Vec3::Zero() || std::any_of(own.begin(), own.end(), moves);
}

void Collide::Impl::compare_collider(std::uint32_t i) {
  const Colliders& c = *colliders;
  SeenCollider& s = seen[i];
  if (c.motion[i] == ColliderMotion::none) {
    s = {};
    return;
  }
  const auto filter = std::tie(c.motion[i], c.sensor[i], c.group[i], c.mask[i], c.object[i]);
  const auto surface =
      std::tie(c.friction_static[i], c.friction_dynamic[i], c.restitution[i], c.rolling_friction[i], c.material[i]);
  auto last_filter = std::tie(s.motion, s.sensor, s.group, s.mask, s.object);
  auto last_surface = std::tie(s.friction_static, s.friction_dynamic, s.restitution, s.rolling_friction, s.material);
  // what has changed
  if (last_filter != filter) s.bits |= kChanged;
  const std::uint32_t conveyor = is_conveyor(i) ? std::uint32_t(kConveyor) : 0u;
  if (conveyor != (s.bits & kConveyor)) s.bits = (s.bits ^ kConveyor) | kSurfaceChanged;
  if (recheck_surfaces || last_surface != surface) s.bits |= kSurfaceChanged;
  // remembered for the next step
  if (s.bits & kChanged) {
    last_filter = filter;
    s.extent = c.shape[i]->extent(to_local(c.pose[i], c.center[i]));
    const Real half = least_half_width(*c.shape[i]);
    s.half_width = half > 0 ? half : kInfinity;
  }
  if (s.bits & kSurfaceChanged) last_surface = surface;
}

void Collide::Impl::compare_motion(std::uint32_t i) {
  const Colliders& c = *colliders;
  if (c.motion[i] == ColliderMotion::none || c.meets_nothing(i)) {
    motion[i] = BoxMotion::absent;
    return;
  }
  SeenCollider& s = seen[i];
  if (c.awake[i])
    s.bits |= kAwake;
  else if (s.bits & kAwake)
    s.bits ^= kAwake | kSettled;
  const bool moving = c.awake[i] || c.sensor[i] || (s.bits & (kChanged | kSettled));
  motion[i] = moving ? BoxMotion::moving : BoxMotion::still;
  if (moving && !c.awake[i] && c.motion[i] != ColliderMotion::dynamic) scenery_changed = true;
}

void Collide::Impl::find_pairs(StepContext& step) {
  if (recheck_filters)
    for (std::uint32_t i = 0; i < colliders->size(); ++i) take_resting(i);
  compare_colliders();
  FEDER_ASSERT(colliders->box.size() == motion.size());
  broad->find_pairs(colliders->box, motion, examined, pairs, *step.jobs);
}

// Does the sensor i leave the collider out, because that is scenery?
static bool overlooks(const Colliders& c, std::uint32_t i, std::uint32_t other) {
  return c.sensor[i] == kSensesMoving && c.motion[other] == ColliderMotion::fixed &&
         c.owner[other] == ColliderOwner::body;
}

bool Collide::Impl::may_collide(std::uint32_t a, std::uint32_t b) const {
  const Colliders& c = *colliders;
  if (c.object[a] == c.object[b]) return false;
  if (c.owner[a] == ColliderOwner::point && c.owner[b] == ColliderOwner::point)
    return false;  // nets and cloths meet as surfaces
  if (!(c.group[a] & c.mask[b]) || !(c.group[b] & c.mask[a])) return false;
  if (c.sensor[a] && c.sensor[b]) return false;  // sensors do not see each other
  if (overlooks(c, a, b) || overlooks(c, b, a)) return false;
  const bool dynamic = c.motion[a] == ColliderMotion::dynamic || c.motion[b] == ColliderMotion::dynamic;
  if (!dynamic && !c.sensor[a] && !c.sensor[b]) return false;
  return exclusions.empty() || !excluded(c.object[a], c.object[b]);
}

// Whether the contact of the last step stays. `reported`: the broad phase found the pair too.
bool Collide::Impl::keep(const ContactEntry& e, bool reported) const {
  const Colliders& c = *colliders;
  if (!reported) {
    if (motion[e.a] != BoxMotion::still || motion[e.b] != BoxMotion::still) return false;
    if (!overlaps(c.box[e.a], c.box[e.b])) return false;
  }
  if (!recheck_filters && !((seen[e.a].bits | seen[e.b].bits) & kChanged)) return true;
  const bool sensor = c.sensor[e.a] || c.sensor[e.b];
  if (sensor != ((e.bits & kSensorPair) != 0) || (c.sensor[e.b] != 0) != ((e.bits & kSensorIsB) != 0)) return false;
  return may_collide(e.a, e.b) && many(e.a, e.b) == (e.bits & (kMany | kFieldPair));
}

// kMany and kFieldPair, for a pair that has several manifolds: a side is neither convex nor a half-space.
int Collide::Impl::many(std::uint32_t a, std::uint32_t b) const {
  const Colliders& c = *colliders;
  if (c.sensor[a] || c.sensor[b]) return 0;
  const auto meshlike = [&](std::uint32_t i) { return !c.shape[i]->convex() && seen[i].extent < kInfinity; };
  if (!meshlike(a) && !meshlike(b)) return 0;
  return is_field(a) || is_field(b) ? kMany | kFieldPair : kMany;
}

void Collide::Impl::create(std::uint32_t a, std::uint32_t b) {
  const Colliders& c = *colliders;
  FEDER_ASSERT(a < b && c.motion[a] != ColliderMotion::none && c.motion[b] != ColliderMotion::none);
  const bool sensor = c.sensor[a] || c.sensor[b];
  const bool scenery = (c.motion[a] == ColliderMotion::dynamic) != (c.motion[b] == ColliderMotion::dynamic);
  const int bits = kNew | (scenery && !sensor ? kAgainstScenery : 0) | (sensor ? kSensorPair : 0) |
                   (c.sensor[b] ? kSensorIsB : 0) | many(a, b);
  ContactEntry e{a, b, kNone, kNone, 0, static_cast<std::uint16_t>(bits)};
  for (; e.sub < entries_of_pair(e.bits); ++e.sub) {
    if (starts_number(e)) {
      e.pair = take_index(free_pairs, memory.size(), [&] { memory.emplace_back(); });
      memory[e.pair] = {};
      measure(memory[e.pair], a, b);
    }
    next_entries.push_back(e);
  }
}

// Frees its slot, and with the first entry of a number that; a contact that was reported gets its end event.
void Collide::Impl::release(const ContactEntry& e) {
  if (e.bits & kReported) count(e, -1);
  if (starts_number(e)) free_pairs.push_back(e.pair);
  if (e.slot == kNone) return;
  FEDER_ASSERT(contacts->slots[e.slot].collider_a == e.a && contacts->slots[e.slot].sub == e.sub);
  free_slot(e.slot);
}

void Collide::Impl::free_slot(std::uint32_t slot) {
  contacts->slots[slot] = Contact{};
  contacts->free_list.push_back(slot);
}

// What follows from the shapes of a pair.
void Collide::Impl::measure(PairMemory& m, std::uint32_t a, std::uint32_t b) const {
  m.about_a = seen[a].extent <= seen[b].extent;
  m.extent = std::min(seen[a].extent, seen[b].extent);
  m.margin = std::min(kSpeculative, kSpeculativeShare * m.extent);
}

// How many entries at the front stay as they are; `pair`: the first of `pairs` that comes after them.
std::size_t Collide::Impl::unchanged_entries(std::size_t& pair) const {
  std::size_t n = 0;
  for (pair = 0; pair < pairs.size(); ++pair) {
    const bool known = n < entries.size() && entries[n].a == pairs[pair].a && entries[n].b == pairs[pair].b;
    const bool gone = n < entries.size() && IndexPair{entries[n].a, entries[n].b} < pairs[pair];
    if (gone || (known ? !keep(entries[n], true) : may_collide(pairs[pair].a, pairs[pair].b))) break;
    if (known) n += entries_of_pair(entries[n].bits);
  }
  return n;
}

// Returns whether `entries` has changed.
bool Collide::Impl::merge_pairs() {
  const bool returned = merge_returning();
  std::size_t first_pair;
  const std::size_t unchanged = unchanged_entries(first_pair);
  std::size_t n = unchanged;
  const auto drop_or_keep = [&](bool reported) {
    FEDER_ASSERT(entries[n].sub == 0);
    const bool kept = keep(entries[n], reported);
    const std::span<const ContactEntry> group(&entries[n], entries_of_pair(entries[n].bits));
    n += group.size();
    if (kept && !reported) rest(group);
    for (const ContactEntry& e : group) {
      if (!kept) release(e);
      if (kept && reported) next_entries.push_back(e);
    }
    return kept;
  };
  for (std::size_t k = first_pair; k < pairs.size(); ++k) {
    const IndexPair& p = pairs[k];
    FEDER_ASSERT(k == 0 || pairs[k - 1] < p);
    while (n < entries.size() && IndexPair{entries[n].a, entries[n].b} < p) drop_or_keep(false);
    const bool known = n < entries.size() && entries[n].a == p.a && entries[n].b == p.b;
    if (known && drop_or_keep(true)) continue;
    if (may_collide(p.a, p.b)) create(p.a, p.b);
  }
  while (n < entries.size()) drop_or_keep(false);
  recheck_filters = false;
  const bool changed = unchanged < entries.size() || !next_entries.empty();
  entries.resize(unchanged);
  entries.insert(entries.end(), next_entries.begin(), next_entries.end());
  next_slack.clear(next_entries);
  return returned || changed;
}

void Collide::Impl::write_order() {
  contacts->order.clear();
  for (const ContactEntry& e : entries)
    if (e.slot != kNone) contacts->order.push_back(e.slot);
}

}  // namespace feder
