// Begin events less end events of a coupling, where asserts are on: as many as there are contacts on record. A record
// that goes without its end event, or comes without its begin event, leaves the two apart.
#pragma once
#include <span>

#include "base/assert.h"
#include "state/events.h"

namespace feder {

class EventBalance {
 public:
  void set(std::size_t records) {
    if constexpr (kAsserts) open_ = records;
  }
  // An event of any kind is about to be sent.
  void count(EventKind kind) {
    if constexpr (!kAsserts) return;
    if (kind == EventKind::contact_begin || kind == EventKind::sensor_enter) ++open_;
    if (kind == EventKind::contact_end || kind == EventKind::sensor_leave) --open_;
  }
  std::size_t open() const { return open_; }

 private:
  std::size_t open_ = 0;
};

// Records of contacts between steps: of live objects of two kinds, each pair once and in ascending order, and as many
// as have begun without an end.
template <class Record>
void validate_records(std::span<const Record> records, ObjectId Record::*a, ObjectKind kind_a, ObjectId Record::*b,
                      ObjectKind kind_b, const Objects& objects, const EventBalance& balance) {
  FEDER_ASSERT(balance.open() == records.size());
  for (std::size_t k = 0; k < records.size(); ++k) {
    const ObjectId x = records[k].*a, y = records[k].*b;
    FEDER_ASSERT(objects.alive(x) && objects.kind(x) == kind_a);
    FEDER_ASSERT(objects.alive(y) && objects.kind(y) == kind_b);
    if (k == 0) continue;
    const ObjectId before = records[k - 1].*a;
    FEDER_ASSERT(before != x ? before < x : records[k - 1].*b < y);
  }
}

}  // namespace feder
