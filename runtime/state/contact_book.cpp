// Merging a step's findings into the sorted records, pair by pair: begin, stay, end, hit and the events of sensors.
#include "state/contact_book.h"

#include <algorithm>
#include <tuple>

#include "feder/error.h"

namespace feder {
namespace {

constexpr Real kMinHitSpeed = Real(0.05);  // m/s; slower begins are no hits

bool earlier(const ContactFinding& x, const ContactFinding& y) {
  return std::tie(x.key, x.order) < std::tie(y.key, y.order);
}

// An event of a pair.
Event event(EventKind kind, const ContactKey& key, std::uint32_t index) {
  Event e;
  e.kind = kind;
  e.a = key.a, e.b = key.b, e.index = index;
  return e;
}

}  // namespace

std::uint32_t ContactBook::finder(std::string_view name) {
  FEDER_ASSERT(finders_.size() < 32);
  std::size_t at = 0;
  while (at < finders_.size() && finders_[at] != name) ++at;
  if (at == finders_.size()) finders_.emplace_back(name);
  return 1u << at;
}

void ContactBook::add(const ContactFinding& finding) {
  FEDER_ASSERT(finding.key.a && finding.key.b && finding.key.a != finding.key.b);
  findings_.push_back(finding);
  findings_.back().order = static_cast<std::uint32_t>(findings_.size());
}

void ContactBook::count(const ContactFinding& finding) {
  FEDER_ASSERT((finding.change == 1 || finding.change == -1) && finding.finder == 0);
  add(finding);
}

void ContactBook::see(std::uint32_t finder, const ContactFinding& finding) {
  FEDER_ASSERT(finder != 0 && (finder & (finder - 1)) == 0 && finding.change == 0);
  add(finding);
  findings_.back().finder = finder;
}

void ContactBook::keep(std::uint32_t finder, const ContactRecord& record) {
  FEDER_ASSERT(record.finders & finder);
  ContactFinding n;
  n.key = record.key;
  n.index = record.index, n.number = record.number;
  n.point = record.point, n.normal = record.normal;
  n.kept = 1;
  see(finder, n);
}

// Records change in place; new ones wait until all findings are read, and are merged in from behind.
void ContactBook::merge(std::uint64_t step, const Objects& objects, Events& events) {
  open_ = records_.size();
  if (findings_.empty() && seen_ == 0) return trim();
  std::sort(findings_.begin(), findings_.end(), earlier);
  const auto over = [](const ContactRecord& r) { return r.count == 0 && r.finders == 0; };
  const std::span<const ContactFinding> findings(findings_.data(), findings_.size());
  std::size_t n = 0;
  bool any_over = false;
  for (std::size_t first = 0; first < findings.size() || n < records_.size();) {
    // records without findings stay as they are
    while (n < records_.size() && records_[n].finders == 0 &&
           (first == findings.size() || records_[n].key < findings[first].key))
      ++n;
    if (first == findings.size() && n == records_.size()) break;
    const bool known = n < records_.size() && (first == findings.size() || !(findings[first].key < records_[n].key));
    ContactRecord fresh;
    if (!known) fresh.key = findings[first].key, fresh.begun = step;
    ContactRecord& record = known ? records_[n++] : fresh;
    std::size_t last = first;
    while (last < findings.size() && findings[last].key == record.key) ++last;
    apply(record, findings.subspan(first, last - first), step, objects, events);
    if (over(record))
      any_over = any_over || known;
    else if (!known)
      added_.push_back(fresh);
    first = last;
  }
  if (any_over) std::erase_if(records_, over);
  insert_added();
  trim();
  seen_ = 0;
  for (const ContactRecord& r : records_) seen_ += r.finders != 0;
}

void ContactBook::trim() {
  added_slack_.clear(added_);
  findings_slack_.clear(findings_);
}

void ContactBook::insert_added() {
  if (records_.empty()) return records_.swap(added_);
  std::size_t from = records_.size(), to = from + added_.size();
  records_.resize(to);
  for (std::size_t k = added_.size(); k > 0;) {
    const bool later = from > 0 && added_[k - 1].key < records_[from - 1].key;
    records_[--to] = later ? records_[--from] : added_[--k];
  }
}

// The findings of one pair: it begins, stays or ends.
void ContactBook::apply(ContactRecord& record, std::span<const ContactFinding> findings, std::uint64_t step,
                        const Objects& objects, Events& events) {
  const bool before = record.count || record.finders;
  record.finders = 0;
  // sums over the findings; the first that begins, ends or is seen, and the first that stays
  const ContactFinding *first = nullptr, *stays = nullptr;
  Real impulse = 0, speed = 0, pressed = 0, slip = 0;
  int count = static_cast<int>(record.count);
  for (const ContactFinding& k : findings) {
    count += k.change;
    if (k.finder && objects.alive(record.key.a) && objects.alive(record.key.b)) record.finders |= k.finder;
    if (!first && (k.change != 0 || k.finder)) first = &k;
    if (k.change > 0 || k.finder) impulse += k.impulse, speed = std::max(speed, k.speed);
    if (k.change != 0 || k.kept) continue;
    if (!stays) stays = &k;
    pressed += k.impulse, slip = std::max(slip, k.slip);
  }
  FEDER_ASSERT(count >= 0);
  record.count = static_cast<std::uint32_t>(count);
  const bool in_contact = record.count || record.finders;
  if (first && (in_contact || first->change != 0)) {
    record.index = first->index;
    record.number = first->number;
    record.point = first->point;
    record.normal = first->normal;
  }
  // stay
  const bool sensor = record.key.sensor != 0;
  if (before == in_contact) {
    if (!in_contact || !stays || sensor || record.begun == step || !events.wanted(EventKind::contact_stay)) return;
    Event e = event(EventKind::contact_stay, record.key, stays->index);
    e.point = stays->point, e.normal = stays->normal, e.impulse = pressed, e.slip = slip;
    events.add(e);
    return;
  }
  // begin or end, and hit
  if (in_contact) record.begun = step;
  const std::uint32_t index = !in_contact && record.number ? 0 : record.index;
  if (sensor)
    return events.add(event(in_contact ? EventKind::sensor_enter : EventKind::sensor_leave, record.key, index));
  Event e = event(in_contact ? EventKind::contact_begin : EventKind::contact_end, record.key, index);
  e.point = record.point, e.normal = record.normal;
  events.add(e);
  if (!in_contact || !events.wanted(EventKind::hit) || speed < kMinHitSpeed) return;
  e.kind = EventKind::hit, e.impulse = impulse, e.speed = speed;
  events.add(e);
}

void ContactBook::load(Reader& r) {
  r.list(records_), r.list(findings_);
  seen_ = 0;
  for (const ContactRecord& k : records_) seen_ += k.finders != 0;
  open_ = records_.size();
}

void ContactBook::validate(const Objects& objects, const Events& events) const {
  FEDER_ASSERT(findings_.empty() || used_ || !records_.empty());
  std::size_t open = open_;
  for (const Event& e : events.list()) {
    open += e.kind == EventKind::contact_begin || e.kind == EventKind::sensor_enter;
    open -= e.kind == EventKind::contact_end || e.kind == EventKind::sensor_leave;
  }
  FEDER_ASSERT(open == records_.size());
  std::size_t seen = 0;
  for (std::size_t n = 0; n < records_.size(); ++n) {
    const ContactRecord& r = records_[n];
    FEDER_ASSERT(r.count > 0 || r.finders != 0);
    FEDER_ASSERT(n == 0 || records_[n - 1].key < r.key);
    FEDER_ASSERT(r.finders == 0 || (objects.alive(r.key.a) && objects.alive(r.key.b)));
    FEDER_ASSERT(finders_.size() == 32 || r.finders >> finders_.size() == 0);
    seen += r.finders != 0;
  }
  FEDER_ASSERT(seen == seen_);
}

}  // namespace feder
