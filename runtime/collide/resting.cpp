// Resting pairs: those whose two sides both lie still. They leave `entries`, so that no pass of a step sees them, and
// wait in lists by collider until a side moves, is changed or is removed. Everything that is read from these lists is
// sorted by (a, b, sub) first: the order in which pairs came to rest decides nothing. Kept between steps: their
// entries; snapshots hold those, and the lists follow from them. Source: sleeping sets, Catto, "Solver sets" (Box2D v3
// / Box3D notes, 2024); written from the idea.
#include <algorithm>

#include "collide/impl.h"

namespace feder {

// The entries of a pair.
void Collide::Impl::rest(std::span<const ContactEntry> group) {
  constexpr std::uint16_t kOfStep = kTested | kWatch | kArrived;
  const ContactEntry& head = group[0];
  const bool mixes = (seen[head.a].bits | seen[head.b].bits) & kSurfaceChanged;
  contacts->resting.reserve(colliders->size(), memory.size());
  RestingPair p;
  for (const ContactEntry& e : group) {
    FEDER_ASSERT(!(e.bits & kSensorPair) && (e.slot != kNone) == ((e.bits & kTouching) != 0));
    if (starts_number(e)) p = {head.a, head.b};
    const std::uint32_t at = e.sub % kMaxContacts;
    p.contact[at] = e.slot;
    p.bits[at] = static_cast<std::uint16_t>((e.bits & ~kOfStep) | kResting | (e.sub >= kMaxContacts ? kSecond : 0));
    if (mixes && e.slot != kNone) mix(contacts->slots[e.slot]);
    if (&e == &group.back() || at == kMaxContacts - 1) contacts->resting.add(e.pair, p);
  }
}

// The resting pairs of a collider into `returning`.
void Collide::Impl::take_resting(std::uint32_t collider) {
  contacts->resting.each_of(collider, [&](std::uint32_t pair) {
    each_resting_entry(pair, [&](const ContactEntry& e) { returning.push_back(e); });
    contacts->resting.remove(pair);
  });
}

// Merges `returning` into `entries`; false when there was nothing to merge.
bool Collide::Impl::merge_returning() {
  if (returning.empty()) return false;
  std::sort(returning.begin(), returning.end(), in_order);
  next_entries.resize(entries.size() + returning.size());
  std::merge(entries.begin(), entries.end(), returning.begin(), returning.end(), next_entries.begin(), in_order);
  entries.swap(next_entries);
  next_slack.clear(next_entries);
  returning.clear();
  return true;
}

// Contacts of what woke after the pairs were found are solved in this step: their data is that of the moment they fell
// asleep, since when neither side has moved.
void Collide::Impl::return_woken() {
  for (const std::uint32_t i : colliders->touched)
    if (colliders->awake[i]) take_resting(i);
  if (!merge_returning()) return;
  write_order();
  watched.clear();
  for (std::uint32_t i = 0; i < entries.size(); ++i)
    if ((entries[i].bits & (kTested | kWatch | kSensorPair)) == (kTested | kWatch)) watched.push_back(i);
}

std::vector<ContactEntry> Collide::Impl::all_entries() const {
  return listed_entries([](const ContactEntry&) { return true; });
}

void Collide::Impl::forget(std::uint32_t collider) {
  FEDER_ASSERT(collider < colliders->size() && colliders->motion[collider] != ColliderMotion::none);
  take_resting(collider);
  // those that stay close up; indices in `watched` follow
  std::uint32_t kept = 0;
  std::size_t next_watched = 0, kept_watched = 0;
  for (std::uint32_t i = 0; i < entries.size(); ++i) {
    const bool is_watched = next_watched < watched.size() && watched[next_watched] == i;
    next_watched += is_watched;
    if (entries[i].a == collider || entries[i].b == collider) {
      returning.push_back(entries[i]);
      continue;
    }
    if (is_watched) watched[kept_watched++] = kept;
    entries[kept++] = entries[i];
  }
  std::sort(returning.begin(), returning.end(), in_order);
  for (const ContactEntry& e : returning) release(e);
  returning.clear();
  if (kept == entries.size()) return;
  watched.resize(kept_watched);
  entries.resize(kept);
  write_order();
  // `active` may name freed slots until the next step
  contacts->active.clear(), contacts->active_pairs.clear();
}

}  // namespace feder
