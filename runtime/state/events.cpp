#include "state/events.h"

#include <algorithm>
#include <tuple>

#include "base/assert.h"

namespace feder {
namespace {
const char* const kEventNames[kEventKinds] = {
    "contact_begin", "contact_stay", "contact_end", "hit",          "sleep",   "wake", "sensor_enter", "sensor_leave",
    "joint_break",   "spring_break", "tear",        "emitter_done", "drained", "step", "warning"};

bool earlier(const Event& x, const Event& y) {
  return std::tie(x.kind, x.a, x.b, x.index, x.order) < std::tie(y.kind, y.a, y.b, y.index, y.order);
}
}  // namespace

const char* event_name(EventKind kind) {
  FEDER_ASSERT(static_cast<int>(kind) < kEventKinds);
  return kEventNames[static_cast<int>(kind)];
}

bool event_kind_from_name(std::string_view name, EventKind& out) {
  for (int i = 0; i < kEventKinds; ++i)
    if (name == kEventNames[i]) return out = static_cast<EventKind>(i), true;
  return false;
}

void Events::set_wanted(EventKind kind, bool wanted) {
  const std::uint32_t bit = 1u << static_cast<int>(kind);
  wanted_ = wanted ? wanted_ | bit : wanted_ & ~bit;
}

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
  list_.clear();
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
    FEDER_ASSERT((e.kind == EventKind::wake) == (e.cause != WakeCause::none));
    FEDER_ASSERT((e.kind == EventKind::warning) == (e.text < warnings_.size()));
    warnings += e.kind == EventKind::warning;
  }
  FEDER_ASSERT(warnings == warnings_.size());
}

}  // namespace feder
