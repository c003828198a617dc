// Invariants of collision detection after each step, asserted where asserts are on (feder/error.h): sorted entries,
// contact slots and their memory agree, active contacts have points, and the number of contacts in the contact book per
// pair of objects is that of the entries, so that no begin or end event was lost.
#include <algorithm>

#include "base/hash.h"
#include "collide/impl.h"

namespace feder {
namespace {

std::uint64_t hash_of(const ContactKey& key) {
  Hash h;
  h.add(key.a.slot), h.add(key.a.generation), h.add(key.b.slot), h.add(key.b.generation);
  h.add(key.index), h.add(key.sensor);
  return h.value();
}

}  // namespace

// What is in no list is as it was.
void Collide::Impl::check_unexamined() {
  const Colliders& c = *colliders;
  checked_boxes.resize(c.size());
  const auto in = [](const Array<std::uint32_t>& list, std::uint32_t i) {
    return std::binary_search(list.begin(), list.end(), i);
  };
  for (std::uint32_t i = 0; i < c.size(); ++i) {
    const Aabb last = checked_boxes[i];
    checked_boxes[i] = c.box[i];
    if (c.motion[i] == ColliderMotion::none) continue;
    const SeenCollider& s = seen[i];
    FEDER_ASSERT(in(changes, i) ||
                 (std::tie(s.motion, s.sensor, s.group, s.mask, s.object) ==
                      std::tie(c.motion[i], c.sensor[i], c.group[i], c.mask[i], c.object[i]) &&
                  std::tie(s.friction_static, s.friction_dynamic, s.restitution, s.rolling_friction) ==
                      std::tie(c.friction_static[i], c.friction_dynamic[i], c.restitution[i], c.rolling_friction[i]) &&
                  s.material == c.material[i] && ((s.bits & kConveyor) != 0) == is_conveyor(i)));
    if (c.meets_nothing(i) && motion[i] == BoxMotion::absent) continue;
    FEDER_ASSERT(in(examined, i) || (!c.awake[i] && !c.sensor[i] && motion[i] == BoxMotion::still &&
                                     !(s.bits & ~kConveyor) && last.lo == c.box[i].lo && last.hi == c.box[i].hi));
  }
}

// An entry and its slot: contacts with points have one, sensors and what is apart have none.
void Collide::Impl::check_entry(const ContactEntry& e) const {
  const Colliders& c = *colliders;
  FEDER_ASSERT(e.a < e.b && e.b < c.size() && e.b < seen.size() && e.pair < memory.size());
  FEDER_ASSERT(c.motion[e.a] != ColliderMotion::none && c.motion[e.b] != ColliderMotion::none);
  const bool touching = e.bits & kTouching, sensor = e.bits & kSensorPair;
  FEDER_ASSERT(!(e.bits & kReported) || touching);
  FEDER_ASSERT((e.slot != kNone) == (touching && !sensor));
  if (e.slot == kNone) return;
  FEDER_ASSERT(e.slot < contacts->slots.size());
  const Contact& contact = contacts->slots[e.slot];
  FEDER_ASSERT(contact.collider_a == e.a && contact.collider_b == e.b && contact.sub == e.sub);
  FEDER_ASSERT(contact.touching && contact.point_count > 0 && contact.point_count <= kMaxContactPoints);
  FEDER_ASSERT(contact.surface <= c.shape[e.a]->surfaces().size() + c.shape[e.b]->surfaces().size());
}

// Contacts and slots, and pairs and their numbers, one to one, in `entries` or at rest; the order of slots is that of
// entries; others are free, once each.
void Collide::Impl::check_entries() const {
  const Contacts& k = *contacts;
  FEDER_ASSERT(bases.size() == k.slots.size());
  MultisetHash slots, listed, pairs_made, pairs_listed;
  for (std::uint32_t slot = 0; slot < k.slots.size(); ++slot) slots.add(slot);
  for (std::uint32_t pair = 0; pair < memory.size(); ++pair) pairs_made.add(pair);
  for (const std::uint32_t pair : free_pairs) pairs_listed.add(pair);
  for (const std::uint32_t slot : k.free_list) {
    FEDER_ASSERT(slot < k.slots.size() && k.slots[slot].collider_a == kNone);
    listed.add(slot);
  }
  const auto list = [&](const ContactEntry& e) {
    if (e.slot != kNone) listed.add(e.slot);
    if (starts_number(e)) pairs_listed.add(e.pair);
  };
  std::size_t next_active = 0, next_slot = 0;
  FEDER_ASSERT(k.active_pairs.size() == k.active.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const ContactEntry& e = entries[i];
    check_entry(e);
    FEDER_ASSERT(i == 0 || in_order(entries[i - 1], e));
    FEDER_ASSERT(e.sub == 0 || (i > 0 && entries[i - 1].a == e.a && entries[i - 1].sub + 1 == e.sub));
    FEDER_ASSERT(starts_number(e) || entries[i - 1].pair == e.pair);
    list(e);
    if (e.slot == kNone) continue;
    FEDER_ASSERT(next_slot < k.order.size() && k.order[next_slot] == e.slot);
    ++next_slot;
    if (next_active == k.active.size() || k.active[next_active] != e.slot) continue;
    FEDER_ASSERT(k.active_pairs[next_active].a == e.a && k.active_pairs[next_active].b == e.b);
    ++next_active;
  }
  FEDER_ASSERT(next_slot == k.order.size());
  FEDER_ASSERT(next_active == k.active.size());  // active ones come in the order of entries, each once
  std::uint32_t resting = 0;
  k.resting.each([&](std::uint32_t pair) {
    each_resting_entry(pair, [&](const ContactEntry& e) { check_entry(e), list(e); });
    ++resting;
  });
  FEDER_ASSERT(slots == listed && pairs_made == pairs_listed && resting == k.resting.count);
}

void Collide::Impl::check_book() const {
  FEDER_ASSERT(watched.empty());  // checked in the step's last pass
  MultisetHash on_record, reported;
  for (const ContactRecord& r : book->records())
    if (r.count > 0) on_record.add(hash_of(r.key), r.count);
  bool flipped = false;
  const auto add = [&](const ContactEntry& e) {
    if (e.bits & kReported) reported.add(hash_of(key(e, flipped)));
  };
  for (const ContactEntry& e : entries) add(e);
  contacts->resting.each([&](std::uint32_t pair) { each_resting_entry(pair, add); });
  FEDER_ASSERT(on_record == reported);
}

void Collide::validate() const {
  impl_->colliders->validate();
  impl_->check_entries();
  impl_->check_book();
  const Array<Exclusion>& list = impl_->exclusions;
  for (std::size_t n = 0; n < list.size(); ++n) {
    FEDER_ASSERT(list[n].count > 0 && list[n].a < list[n].b);
    FEDER_ASSERT(n == 0 || std::tie(list[n - 1].a, list[n - 1].b) < std::tie(list[n].a, list[n].b));
  }
}

}  // namespace feder
