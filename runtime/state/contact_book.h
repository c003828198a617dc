// Contact records: one per pair of objects in contact, with one rule for begin, stay and end, whoever finds the
// contacts. Finders report findings before Rank::contact_events or between steps: either the begin and end of contacts
// that they keep themselves (`count`), or in each step the pairs they found (`see`; `keep` without a test). A pair is
// in contact while one of its contacts is counted or a finder sees it; at Rank::contact_events findings are merged into
// the records and make the events, so that begins and ends alternate, one per pair. Pairs with a destroyed object end.
// Sensors: the same for what is inside; of nets by point.
// Kept between steps: the records, and findings since the last merge. tests/contact/test_contact_book.cpp.
#pragma once
#include <span>
#include <string_view>
#include <vector>

#include "feder/events.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/snapshot.h"
#include "feder/types.h"

namespace feder {

struct ContactKey {
  ObjectId a, b;            // in the order of the events; sensors: a is the sensor
  std::uint32_t index = 0;  // sensors: point of the net, if the other is a net
  std::uint32_t sensor = 0;
  friend auto operator<=>(const ContactKey&, const ContactKey&) = default;
};

// A finding about a pair in a step.
struct ContactFinding {
  ContactKey key;
  std::int32_t change = 0;     // counted contacts that began or ended
  std::uint32_t finder = 0;    // bit of the finder that saw the pair
  std::uint32_t index = 0;     // point, spring or vertex of `a`, or a number of particles
  std::uint32_t number = 0;    // 1: `index` is a number, 0 when the pair ends
  std::uint32_t kept = 0;      // 1: seen without a test
  std::uint32_t order = 0;     // filled by the book
  Vec3 point = Vec3::Zero();   // world, m
  Vec3 normal = Vec3::Zero();  // from a to b
  Real speed = 0;              // closing, m/s
  Real slip = 0;               // tangential, m/s
  Real impulse = 0;            // along the normal in this step, N s
};

static_assert(sizeof(ContactFinding) == 48 + 9 * sizeof(Real));

// No padding: written to snapshots as bytes.
struct ContactRecord {
  ContactKey key;
  std::uint32_t count = 0;                           // of contacts
  std::uint32_t finders = 0;                         // bits of those that see it
  std::uint32_t index = 0, number = 0;               // of the last finding
  std::uint64_t begun = 0;                           // step
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  // where it was last seen (pairs that finders see)
};
static_assert(sizeof(ContactRecord) == 48 + 6 * sizeof(Real));

class ContactBook {
 public:
  explicit ContactBook(Arena& arena) : records_(&arena), added_(&arena), findings_(&arena) {}

  // The bit of a finder that sees. Worlds that are made alike give equal bits.
  std::uint32_t finder(std::string_view name);
  // While the plan is made: a finder will report findings.
  void use() { used_ = true; }

  // A counted contact of that pair began (change 1) or ended (-1).
  void count(const ContactFinding& finding);
  // A counted pair that stays, for contact_stay: only where that is wanted.
  void stay(const ContactFinding& finding) { add(finding); }
  // `finder` saw the pair in this step; once per pair and finder.
  void see(std::uint32_t finder, const ContactFinding& finding);
  // `finder` saw the pair earlier, and nothing has moved since.
  void keep(std::uint32_t finder, const ContactRecord& record);

  const Array<ContactRecord>& records() const { return records_; }  // in the order of keys
  // Calls f(record) for the pairs that `finder` sees.
  template <class F>
  void each(std::uint32_t finder, F&& f) const {
    if (seen_ == 0) return;
    for (const ContactRecord& r : records_)
      if (r.finders & finder) f(r);
  }

  // For the world.
  void begin_plan() { used_ = false, open_ = records_.size(); }
  bool wanted() const { return used_ || !records_.empty() || !findings_.empty(); }
  void merge(std::uint64_t step, const Objects& objects, Events& events);
  void save(Writer& w) const { w.list(records_), w.list(findings_); }
  void load(Reader& r);
  // After a step: its records have begun and not ended, in the events that were really sent.
  void validate(const Objects& objects, const Events& events) const;

 private:
  void add(const ContactFinding& finding);
  void apply(ContactRecord& record, std::span<const ContactFinding> findings, std::uint64_t step,
             const Objects& objects, Events& events);
  void insert_added();
  void trim();

  std::vector<std::string> finders_;  // by bit
  Array<ContactRecord> records_, added_;
  Array<ContactFinding> findings_;
  Slack added_slack_, findings_slack_;
  std::size_t seen_ = 0;  // records that a finder sees
  std::size_t open_ = 0;  // records before the merge of this step
  bool used_ = false;
};

}  // namespace feder
