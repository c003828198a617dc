// The list of a step's events: appended by passes, sorted by kind and objects at its end, so that the order does not
// depend on who appended first.
#include "feder/events.h"

#include <algorithm>
#include <tuple>

#include "feder/error.h"

namespace feder {
namespace {
bool earlier(const Event& x, const Event& y) {
  return std::tie(x.kind, x.a, x.b, x.index, x.order) < std::tie(y.kind, y.a, y.b, y.index, y.order);
}
}  // namespace

void Events::set_wanted(EventKind kind, bool wanted) {
  std::erase(wanted_, kind);
  if (wanted) wanted_.push_back(kind);
}

bool Events::wanted(EventKind kind) const { return std::find(wanted_.begin(), wanted_.end(), kind) != wanted_.end(); }

void Events::add(const Event& e) {
  list_.push_back(e);
  list_.back().order = static_cast<std::uint32_t>(list_.size());
}

void Events::add_pending(const Event& e) { pending_.push_back(e); }

void Events::warn(std::string code, std::string message, ObjectId object) {
  for (const auto& w : warnings_)
    if (w.first == code) return;
  FEDER_ASSERT(!code.empty() && !message.empty());
  Event e;
  e.kind = EventKind::warning;
  e.a = object;
  e.text = static_cast<std::uint32_t>(warnings_.size());
  warnings_.emplace_back(std::move(code), std::move(message));
  add(e);
}

void Events::clear() {
  slack_.clear(list_);
  warnings_.clear();
}

void Events::finish() {
  for (const Event& e : pending_) add(e);
  pending_.clear();
  std::sort(list_.begin(), list_.end(), earlier);
}

void Events::validate() const {
  FEDER_ASSERT(pending_.empty());
  std::size_t warnings = 0;
  for (std::size_t k = 0; k < list_.size(); ++k) {
    const Event& e = list_[k];
    FEDER_ASSERT(k == 0 || earlier(list_[k - 1], e));
    FEDER_ASSERT(e.kind.has(EventKind::kCause) == (e.cause != WakeCause::none));
    FEDER_ASSERT(e.kind.has(EventKind::kText) == (e.text < warnings_.size()));
    warnings += e.kind == EventKind::warning;
  }
  FEDER_ASSERT(warnings == warnings_.size());
}

}  // namespace feder
