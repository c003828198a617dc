// What happened in a step, as plain buffers. Rows append; the world sorts once in `finish`; handlers read after the
// step. Nothing here calls anybody.
#pragma once
#include <string>
#include <vector>

#include "base/arena.h"
#include "base/assert.h"
#include "base/name.h"
#include "state/objects.h"

namespace feder {

enum class EventKind : std::uint8_t {
  contact_begin,
  contact_stay,
  contact_end,
  hit,
  sleep,
  wake,
  sensor_enter,
  sensor_leave,
  joint_break,
  spring_break,
  tear,
  emitter_done,
  drained,
  step,
  warning,
};
inline constexpr int kEventKinds = 15;
const char* event_name(EventKind kind);  // "contact_begin" ...
bool event_kind_from_name(std::string_view name, EventKind& out);

// What woke something; systems list theirs in their descriptor.
struct WakeCause : Name<WakeCause> {
  using Name::Name;
  static const WakeCause none, contact, script, joint, neighbor, force, destroyed;
};
inline constexpr WakeCause WakeCause::none{"none"}, WakeCause::contact{"contact"}, WakeCause::script{"script"},
    WakeCause::joint{"joint"}, WakeCause::neighbor{"neighbor"}, WakeCause::force{"force"},
    WakeCause::destroyed{"destroyed"};
inline constexpr WakeCause kWakeCauses[] = {WakeCause::contact,  WakeCause::script, WakeCause::joint,
                                            WakeCause::neighbor, WakeCause::force,  WakeCause::destroyed};

// Fields that a kind does not use stay at their defaults.
struct Event {
  EventKind kind = EventKind::step;
  WakeCause cause = WakeCause::none;  // wake
  ObjectId a, b;  // contacts: bodies or nets; sensors: a = sensor, b = other; others: a = object; wake: b = other;
                  // emitters and drains: b = fluid
  std::uint32_t index = 0;     // point, spring or vertex of `a` (counts from 0)
  std::uint32_t order = 0;     // filled on append: keeps equal keys in the order they came
  Vec3 point = Vec3::Zero();   // world, m
  Vec3 normal = Vec3::Zero();  // from a to b
  Real speed = 0;              // approach speed, m/s (hit)
  Real impulse = 0;            // accumulated normal impulse of the step, N s
  Real slip = 0;               // tangential speed at the contact, m/s (contact_stay)
  Real force = 0;              // N (breaks)
  std::uint32_t text = kNone;  // warning: index into Events::text
};

class Events {
 public:
  explicit Events(Arena& arena) : list_(&arena), pending_(&arena) {}

  // Kinds that cost something to make (contact_stay, hit) are only made when wanted.
  void set_wanted(EventKind kind, bool wanted);
  bool wanted(EventKind kind) const { return wanted_ >> static_cast<int>(kind) & 1u; }

  // Inside a step, from one thread.
  void add(const Event& e);
  // Outside a step (destroy, teleport, filter change, script wake): kept for the next finish().
  void add_pending(const Event& e);
  // `code` is one word ("mass_ratio"); the message one sentence. Repeats of a code in one step are counted, not kept.
  void warn(std::string code, std::string message, ObjectId object = {});

  void clear();   // at `begin`
  void finish();  // takes the pending ones in and sorts by (kind, a, b, index, order)

  const Array<Event>& list() const { return list_; }
  void validate() const;  // after finish(): asserts order and contents
  const std::string& warning_code(const Event& e) const { return warning(e).first; }
  const std::string& warning_message(const Event& e) const { return warning(e).second; }

 private:
  const std::pair<std::string, std::string>& warning(const Event& e) const {
    FEDER_ASSERT(e.kind == EventKind::warning && e.text < warnings_.size());
    return warnings_[e.text];
  }

  Array<Event> list_, pending_;
  std::vector<std::pair<std::string, std::string>> warnings_;
  std::uint32_t wanted_ = 0;
};

}  // namespace feder
