// Invariants of collision detection after each step, asserted where asserts are on (feder/error.h): sorted entries,
// contact slots and their memory agree, active contacts have points, and the number of contacts in the contact book per
// pair of objects is that of the entries, so that no begin or end event was lost.
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

// Entries and slots, one to one; the order of slots is that of entries; other slots are free, once each.
void Collide::Impl::check_entries() const {
  const Colliders& c = *colliders;
  const Contacts& k = *contacts;
  FEDER_ASSERT(memory.size() == k.slots.size() && k.order.size() == entries.size());
  MultisetHash all, listed;
  for (std::uint32_t slot = 0; slot < k.slots.size(); ++slot) all.add(slot);
  for (const std::uint32_t slot : k.free_list) {
    FEDER_ASSERT(slot < k.slots.size() && k.slots[slot].collider_a == kNone);
    listed.add(slot);
  }
  std::size_t next_active = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const ContactEntry& e = entries[i];
    FEDER_ASSERT(e.a < e.b && e.b < c.size() && e.b < seen.size());
    if (i > 0) {
      const ContactEntry& before = entries[i - 1];
      FEDER_ASSERT(std::tie(before.a, before.b, before.sub) < std::tie(e.a, e.b, e.sub));
    }
    FEDER_ASSERT(c.motion[e.a] != ColliderMotion::none && c.motion[e.b] != ColliderMotion::none);
    FEDER_ASSERT(k.order[i] == e.slot && e.slot < k.slots.size());
    listed.add(e.slot);
    const Contact& contact = k.slots[e.slot];
    FEDER_ASSERT(contact.collider_a == e.a && contact.collider_b == e.b && contact.sub == e.sub);
    FEDER_ASSERT((contact.sensor != 0) == ((e.bits & kSensorPair) != 0));
    FEDER_ASSERT((contact.touching != 0) == ((e.bits & kTouching) != 0));
    FEDER_ASSERT(!(e.bits & kReported) || contact.touching);
    FEDER_ASSERT(contact.point_count <= (contact.touching && !contact.sensor ? kMaxContactPoints : 0));
    if (next_active == k.active.size() || k.active[next_active] != e.slot) continue;
    FEDER_ASSERT(contact.point_count > 0);
    ++next_active;
  }
  FEDER_ASSERT(all == listed);
  FEDER_ASSERT(next_active == k.active.size());  // active ones come in the order of entries, each once
}

void Collide::Impl::check_book() const {
  FEDER_ASSERT(watched.empty());  // checked in the step's last pass
  MultisetHash on_record, reported;
  for (const ContactRecord& r : book->records())
    if (r.count > 0) on_record.add(hash_of(r.key), r.count);
  bool flipped = false;
  for (const ContactEntry& e : entries)
    if (e.bits & kReported) reported.add(hash_of(key(e, flipped)));
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
