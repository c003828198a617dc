// Subscriptions of one world, and their dispatch after a step. Filters are evaluated here, before any Lua call.
#pragma once
#include <memory>
#include <unordered_map>
#include <vector>

#include "feder/events.h"
#include "lua/state.h"

namespace feder::lua {

class Options;

struct EventFilter {
  bool has_tags = false;
  TagMask tags = 0;       // one of the objects has one of them
  ObjectId a, b, object;  // a and b also swap the sides of the event so that e.a is a
  Real min_speed = 0, min_impulse = 0, min_force = 0, min_slip = 0;
  WakeCause cause = WakeCause::none;  // wake; none: any
};

struct Subscription {
  std::uint64_t id = 0;  // grows: handlers run in the order of subscription
  EventKind kind = EventKind::step;
  EventFilter filter;
  ObjectId self;     // of object:on; none for world:on
  int function = 0;  // key in the world's callbacks; 0: wakes the task below
  std::uint64_t task = 0;
  std::size_t profile = 0;
  bool live = true;
  bool self_died = false;  // kept for one dispatch more, which brings the end events
};

struct Subscriptions {
  struct PerKind {
    explicit PerKind(EventKind of) : kind(of) {}
    EventKind kind;
    std::vector<Subscription*> world = {};                                      // ascending ids
    std::unordered_map<std::uint32_t, std::vector<Subscription*>> object = {};  // by slot; looked up, never iterated
  };
  std::vector<PerKind> kinds;  // that somebody subscribed to
  PerKind* find(EventKind kind) {
    for (PerKind& k : kinds)
      if (k.kind == kind) return &k;
    return nullptr;
  }
  std::vector<std::unique_ptr<Subscription>> all;  // ascending ids
  std::uint64_t next_id = 1;
  std::vector<Event> events;  // being dispatched, or of the last step
  std::vector<Subscription*> matches;
};

// Which side of an event a subscription sees as `a`: no match, as it is, or swapped.
enum class Side { none, same, swapped };
Side match(const WorldRecord& record, const Subscription& s, const Event& e);

Subscription& subscribe(WorldRecord& record, EventKind kind, const EventFilter& filter, ObjectId self);
bool unsubscribe(lua_State* L, WorldRecord& record, std::uint64_t id);

// Runs the handlers of the last step's events.
void dispatch_events(lua_State* L, WorldRecord& record);

EventKind check_event_kind(lua_State* L, int index, const WorldRecord& record);
EventFilter read_filter(lua_State* L, int index, WorldRecord& record, EventKind kind);
// A plain table with the fields of the event.
void push_event_copy(lua_State* L, WorldRecord& record, const Event& e, bool swapped);
// self:on(kind, [filter], fn); pushes the connection.
int push_subscription(lua_State* L, WorldRecord& record, ObjectId self);
int world_on(lua_State* L);
int world_events(lua_State* L);
void open_events(lua_State* L);
std::span<const Method> event_methods();
std::span<const Method> connection_methods();

}  // namespace feder::lua
