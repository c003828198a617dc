// Events of a step as plain buffers: passes append, the world sorts once at the end of the step, hosts read after it.
// No callbacks. World::step() replaces the list; read it on the thread that steps, between two steps.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "feder/error.h"
#include "feder/memory.h"
#include "feder/object.h"

namespace feder {

// A kind of event; systems list theirs in their descriptor. Kinds of a step come in the order of their names.
struct EventKind : Name<EventKind> {
  // Fields that its events use beside their object, which is `a`.
  enum Tells : std::uint32_t {
    kPair = 1,      // not one object but two, a and b, in either order for filters; point, and normal from a to b
    kSensed = 2,    // b, which the sensor a detected
    kOther = 4,     // b
    kPlace = 8,     // index: a point, spring or vertex of a
    kAmount = 16,   // index: how many
    kSpeed = 32,    // m/s
    kImpulse = 64,  // N s
    kSlip = 128,    // m/s
    kForce = 256,   // N
    kCause = 512,   // of a wake
    kText = 1024,   // code and message
    kAlone = 2048,  // no object
    kPart = 4096,   // of a
  };
  constexpr EventKind(const char* name, std::uint32_t what) : Name(name), fields(what) {}
  constexpr bool has(std::uint32_t any) const { return (fields & any) != 0; }

  std::uint32_t fields;
  static const EventKind contact_begin, contact_end, contact_stay, hit, sensor_enter, sensor_leave, sleep, wake, step,
      warning;
};
inline constexpr EventKind EventKind::contact_begin{"contact_begin", kPair},
    EventKind::contact_end{"contact_end", kPair}, EventKind::contact_stay{"contact_stay", kPair | kImpulse | kSlip},
    EventKind::hit{"hit", kPair | kImpulse | kSpeed}, EventKind::sensor_enter{"sensor_enter", kSensed},
    EventKind::sensor_leave{"sensor_leave", kSensed}, EventKind::sleep{"sleep", 0},
    EventKind::wake{"wake", kOther | kCause}, EventKind::step{"step", kAlone}, EventKind::warning{"warning", kText};
// Of every world.
inline constexpr EventKind kEventKinds[] = {
    EventKind::contact_begin, EventKind::contact_end, EventKind::contact_stay, EventKind::hit,  EventKind::sensor_enter,
    EventKind::sensor_leave,  EventKind::sleep,       EventKind::wake,         EventKind::step, EventKind::warning};

// Cause of a wake event; systems list theirs in their descriptor.
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
  std::uint32_t part = 0;      // of `a` (counts from 0)
  std::uint32_t text = kNone;  // warning: index into Events::text
};

class Events {
 public:
  explicit Events(Arena& arena) : list_(&arena), pending_(&arena) {}

  // Costly kinds (contact_stay, hit) are only made when wanted.
  void set_wanted(EventKind kind, bool wanted);
  bool wanted(EventKind kind) const;

  // Inside a step, from one thread.
  void add(const Event& e);
  // Outside a step (destroy, teleport, filter change, script wake): kept for the next finish().
  void add_pending(const Event& e);
  // `code` is one word ("mass_ratio"); the message one sentence. Repeats of a code in one step are counted, not kept.
  void warn(std::string code, std::string message, ObjectId object = {});

  void clear();   // at `begin`
  void finish();  // appends the pending ones and sorts by (kind, a, b, index, order)

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
  Slack slack_;  // of list_
  std::vector<std::pair<std::string, std::string>> warnings_;
  std::vector<EventKind> wanted_;
};

}  // namespace feder
