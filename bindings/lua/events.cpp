// Events: matching, dispatch after the step, and the event object that handlers read.
#include "lua/events.h"

#include <algorithm>

#include "lua/docs.h"
#include "lua/method.h"
#include "lua/sandbox.h"

namespace feder::lua {
namespace {

bool is_source(EventKind k) { return k.has(EventKind::kAmount); }  // of an emitter or drain, and its fluid
bool has_two(EventKind k) { return k.has(EventKind::kPair | EventKind::kSensed); }

// What the event object reads from. Valid while its handler runs, or until its iterator moves on.
struct EventBlock {
  std::uint32_t world = 0;
  bool valid = false;
  bool swapped = false;
  bool own = false;  // of a handler of an object
  Event event;
};

// Do contacts with that object report where on it, under this name?
bool reports(lua_State* L, const WorldRecord& r, ObjectId id, std::string_view field) {
  const State& s = state(L);
  const ObjectClass* row = id ? class_row(s, class_of(s, r, id)) : nullptr;
  return row && row->contact_field && field == row->contact_field;
}

// An event as a subscription sees it: a and b change places when it is swapped.
struct EventView {
  lua_State* L;
  WorldRecord& record;
  const Event& e;
  bool swapped, own;

  void object(ObjectId id) const { push_handle(L, record, id); }
  // Does one of its two objects, `id`, report where on it, under this name?
  bool reported(ObjectId id, std::string_view field) const { return has_two(e.kind) && reports(L, record, id, field); }
  void index(bool told, lua_Integer first) const {
    told ? push(L, static_cast<lua_Integer>(e.index) + first) : push(L, nullptr);
  }
};

template <Real Event::*Member>
void push_number(const EventView& v) {
  push(v.L, v.e.*Member);
}
template <int kAxis>
void push_coordinate(const EventView& v) {
  push(v.L, v.e.point[kAxis]);
}
template <int kAxis>
void push_normal(const EventView& v) {
  push(v.L, (v.swapped ? Real(-1) : Real(1)) * v.e.normal[kAxis]);
}
template <auto Text>
void push_warning(const EventView& v) {
  v.e.text == kNone ? push(v.L, nullptr) : push(v.L, (v.record.world->events().*Text)(v.e));
}

constexpr std::uint32_t kEvery = 0, kOneObject = 1u << 31, kOwnPair = 1u << 30;

// A field of events, nil where an event's kind has none of `of`; kEvery: of all kinds, kOneObject: of those about one
// object, kOwnPair: of pairs, in handlers of one of the two.
struct EventField {
  OptionRow row;
  const char* type;
  std::uint32_t of;
  void (*push)(const EventView& v);  // none: of a method
};
constexpr std::uint32_t kTwo = EventKind::kPair | EventKind::kSensed;
constexpr EventField kFields[] = {
    {{"kind"}, "string", kEvery, [](const EventView& v) { push(v.L, v.e.kind.text()); }},
    {{"time", "s"}, "number", kEvery, [](const EventView& v) { push(v.L, v.record.world->time()); }},
    {{"step"}, "integer", kEvery, [](const EventView& v) { push(v.L, v.record.world->step_count()); }},
    {{"a"}, "object", EventKind::kPair, [](const EventView& v) { v.object(v.swapped ? v.e.b : v.e.a); }},
    {{"b"}, "object", EventKind::kPair, [](const EventView& v) { v.object(v.swapped ? v.e.a : v.e.b); }},
    {{"x", "m"}, "number", EventKind::kPair, push_coordinate<0>},
    {{"y", "m"}, "number", EventKind::kPair, push_coordinate<1>},
    {{"z", "m"}, "number", EventKind::kPair, push_coordinate<2>},
    {{"nx"}, "number", EventKind::kPair, push_normal<0>},
    {{"ny"}, "number", EventKind::kPair, push_normal<1>},
    {{"nz"}, "number", EventKind::kPair, push_normal<2>},
    {{"impulse", "N s"}, "number", EventKind::kImpulse, push_number<&Event::impulse>},
    {{"slip", "m/s"}, "number", EventKind::kSlip, push_number<&Event::slip>},
    {{"speed", "m/s"}, "number", EventKind::kSpeed, push_number<&Event::speed>},
    {{"object"}, "object", kOneObject, [](const EventView& v) { v.object(v.e.a); }},
    {{"cause"}, "string", EventKind::kCause, [](const EventView& v) { push(v.L, v.e.cause.text()); }},
    {{"other"},
     "object",
     EventKind::kOther | EventKind::kSensed | kOwnPair,
     [](const EventView& v) { v.object(v.e.kind.has(EventKind::kPair) && v.swapped ? v.e.a : v.e.b); }},
    {{"sensor"}, "object", EventKind::kSensed, [](const EventView& v) { v.object(v.e.a); }},
    {{"index"},
     "integer",
     EventKind::kPlace | kTwo,
     [](const EventView& v) {
       v.index(v.e.kind.has(EventKind::kPlace) || v.reported(v.e.a, "index") || v.reported(v.e.b, "index"), 1);
     }},
    {{"force", "N"}, "number", EventKind::kForce, push_number<&Event::force>},
    {{"part"},
     "integer",
     EventKind::kPart,
     [](const EventView& v) { push(v.L, static_cast<lua_Integer>(v.e.part) + 1); }},
    {{"count"},
     "integer",
     EventKind::kAmount | kTwo,
     [](const EventView& v) { v.index(is_source(v.e.kind) || v.reported(v.e.b, "count"), 0); }},
    {{"code"}, "string", EventKind::kText, push_warning<&Events::warning_code>},
    {{"message"}, "string", EventKind::kText, push_warning<&Events::warning_message>},
    {{"copy"}, "method", kEvery, nullptr},
};

bool carries(EventKind kind, const EventField& field, bool own) {
  if (field.of == kOneObject) return !kind.has(kTwo | EventKind::kAlone);
  return field.of == kEvery || kind.has(field.of) || (own && (field.of & kOwnPair) && kind.has(EventKind::kPair));
}

void push_field(const EventView& v, const EventField& field) {
  carries(v.e.kind, field, v.own) ? field.push(v) : lua_pushnil(v.L);
}

bool readable(lua_State* L, const EventBlock& block) { return block.valid && state(L).worlds[block.world]->world; }

// Of a block that is readable.
EventView view_of(lua_State* L, const EventBlock& block) {
  return {L, *state(L).worlds[block.world], block.event, block.swapped, block.own};
}

// A plain table with the fields of the event.
void push_fields(const EventView& v) {
  lua_newtable(v.L);
  for (const EventField& field : kFields) {
    if (!field.push) continue;
    push_field(v, field);
    lua_setfield(v.L, -2, field.row.name);
  }
}

const EventBlock& check_event(lua_State* L, const char* what) {
  const auto* block = static_cast<const EventBlock*>(test_class(L, 1, Class::event));
  if (!block) fail(L, std::string(what) + ": expected an event before the ':', got " + describe(L, 1));
  if (!readable(L, *block)) fail(L, std::string(what) + ": an event is valid inside its handler only; copy it there");
  return *block;
}

int event_copy(lua_State* L) {
  push_fields(view_of(L, check_event(L, "event:copy")));
  return 1;
}

// The fields that it has, as pairs gives those of its copy.
int event_pairs(lua_State* L) {
  const EventBlock& block = check_event(L, "pairs");
  lua_getglobal(L, "pairs");
  push_fields(view_of(L, block));
  lua_call(L, 1, 3);
  return 3;
}

int event_index(lua_State* L) {  // upvalues: table of fields, copy
  const auto* block = static_cast<const EventBlock*>(lua_touserdata(L, 1));
  lua_pushvalue(L, 2);
  lua_rawget(L, lua_upvalueindex(1));
  const auto number = static_cast<std::size_t>(lua_tointeger(L, -1));
  if (number == 0) {
    std::vector<std::string> known;
    for (const EventField& f : kFields) known.emplace_back(f.row.name);
    fail(L,
         "event: no field " + describe(L, 2) +
             (lua_type(L, 2) == LUA_TSTRING ? did_you_mean_or(lua_tostring(L, 2), known) : "; known: " + join(known)));
  }
  const EventField& field = kFields[number - 1];
  if (!field.push) {
    lua_pushvalue(L, lua_upvalueindex(2));
    return 1;
  }
  if (!readable(L, *block))
    fail(L,
         "event." + std::string(field.row.name) + ": an event is valid inside its handler only; keep it with e:copy()");
  push_field(view_of(L, *block), field);
  return 1;
}

int event_no_write(lua_State* L) { fail(L, "event: an event cannot be changed; e:copy() gives a table"); }

// "event hit { a = body "ball", speed = 3.2, ... }", without the fields that it does not have.
std::string event_tostring(lua_State* L) {
  const auto* block = static_cast<const EventBlock*>(test_class(L, 1, Class::event));
  if (!block || !readable(L, *block)) return "event (over)";
  std::string text;
  for (const EventField& field : kFields) {
    if (!field.push || std::string_view(field.row.name) == "kind") continue;
    push_field(view_of(L, *block), field);
    if (!lua_isnil(L, -1)) {
      push_text(L, -1);
      text += (text.empty() ? " " : ", ") + std::string(field.row.name) + " = " + std::string(text_at(L, -1));
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  }
  return std::string("event ") + block->event.kind.text() + " {" + text + " }";
}

EventBlock& push_event(lua_State* L, const WorldRecord& record) {
  return push_userdata(L, Class::event, EventBlock{record.id, false, false, false, {}});
}

void forget_subscription(lua_State* L, WorldRecord& record, Subscription& s) {
  s.live = false;
  drop(L, record, s.function);
  s.function = 0;
}

// Takes dead subscriptions out of the lists.
void compact(lua_State* L, WorldRecord& record) {
  Subscriptions& subs = record.subscriptions;
  const Objects& objects = record.world->objects();
  bool any = false;
  for (auto& s : subs.all) {
    if (s->live && s->self && !objects.alive(s->self)) {
      if (s->self_died) forget_subscription(L, record, *s);
      s->self_died = true;
    }
    any = any || !s->live;
  }
  if (!any) return;
  const auto dead = [](const Subscription* s) { return !s->live; };
  for (auto& kind : subs.kinds) {
    std::erase_if(kind.world, dead);
    for (auto& entry : kind.object) std::erase_if(entry.second, dead);
    std::erase_if(kind.object, [](const auto& entry) { return entry.second.empty(); });
  }
  std::erase_if(subs.all, [](const auto& s) { return !s->live; });
}

void find_matches(WorldRecord& record, const Event& e, std::uint64_t newest) {
  Subscriptions& subs = record.subscriptions;
  subs.matches.clear();
  const Subscriptions::PerKind* kind = subs.find(e.kind);
  if (!kind) return;
  const auto take = [&](const std::vector<Subscription*>& list) {
    for (Subscription* s : list)
      if (s->live && s->id <= newest && match(record, *s, e) != Side::none) subs.matches.push_back(s);
  };
  take(kind->world);
  for (ObjectId id : {e.a, e.b}) {
    if (!id || kind->object.empty()) continue;
    if (const auto found = kind->object.find(id.slot); found != kind->object.end()) take(found->second);
    if (e.a == e.b) break;
  }
  std::sort(subs.matches.begin(), subs.matches.end(),
            [](const Subscription* x, const Subscription* y) { return x->id < y->id; });
}

// Hands the event to a task that waits for it.
void deliver_to_task(lua_State* L, WorldRecord& record, Subscription& s, const Event& e) {
  Task* task = find_task(record, s.task);
  s.live = false;
  if (!task) return;
  push_event_copy(L, record, e, match(record, s, e) == Side::swapped);
  task->event = keep(L, record, -1);
  task->state = TaskState::ready;
  lua_pop(L, 1);
}

int next_event(lua_State* L) {  // upvalues: position, kind, step count, event userdata, world
  auto* block = static_cast<EventBlock*>(lua_touserdata(L, lua_upvalueindex(4)));
  WorldRecord& r = *state(L).worlds[block->world];
  block->valid = false;
  if (!r.world || lua_tointeger(L, lua_upvalueindex(3)) != static_cast<lua_Integer>(r.world->step_count())) return 0;
  const auto& list = r.subscriptions.events;
  for (std::size_t i = static_cast<std::size_t>(lua_tointeger(L, lua_upvalueindex(1))); i < list.size(); ++i) {
    if (lua_tostring(L, lua_upvalueindex(2)) != std::string_view(list[i].kind.text())) continue;
    lua_pushinteger(L, static_cast<lua_Integer>(i) + 1);
    lua_replace(L, lua_upvalueindex(1));
    block->event = list[i];
    block->valid = true;
    lua_pushvalue(L, lua_upvalueindex(4));
    return 1;
  }
  return 0;
}

bool connection_disconnect(lua_State* L) {
  const auto* c = static_cast<const Connection*>(self_block(L));
  if (!c) wrong_self(L, "connection");
  WorldRecord& r = *state(L).worlds[c->world];
  if (!r.world) return false;
  return c->kind == ConnectionKind::event ? unsubscribe(L, r, c->id) : cancel_timer(L, r, c->id);
}

const Method kConnectionMethods[] = {
    {"disconnect", method<connection_disconnect>, "c:disconnect() -> boolean",
     "ends a subscription or timer; false when it had ended"},
};
const Method kEventMethods[] = {
    {"copy", guard<event_copy>, "e:copy() -> table",
     "the event's fields in a table of their own, to keep after the handler"},
};

}  // namespace

std::span<const Method> event_methods() { return kEventMethods; }
std::vector<OptionInfo> event_fields(EventKind kind, bool own) {
  std::vector<OptionInfo> all;
  for (const EventField& f : kFields)
    if (f.push && carries(kind, f, own)) all.push_back({.row = f.row, .type = f.type, .fallback = "", .choices = ""});
  return all;
}
std::span<const Method> connection_methods() { return kConnectionMethods; }

void push_event_copy(lua_State* L, WorldRecord& record, const Event& e, bool swapped) {
  push_fields({L, record, e, swapped, false});
}

Side match(const WorldRecord& record, const Subscription& s, const Event& e) {
  const EventFilter& f = s.filter;
  if (e.speed < f.min_speed || e.impulse < f.min_impulse || e.force < f.min_force || e.slip < f.min_slip)
    return Side::none;
  if (f.cause != WakeCause::none && e.cause != f.cause) return Side::none;
  if (f.object && e.a != f.object && !((has_two(e.kind) || is_source(e.kind)) && e.b == f.object)) return Side::none;
  if (f.has_tags) {
    const Objects& objects = record.world->objects();
    const TagMask tags = objects.tags(e.a) | (has_two(e.kind) ? objects.tags(e.b) : 0);
    if (!(tags & f.tags)) return Side::none;
  }
  ObjectId a = f.a, b = f.b;
  if (s.self) {
    if (is_source(e.kind)) return e.a == s.self || e.b == s.self ? Side::same : Side::none;
    if (!has_two(e.kind)) return e.a == s.self && (!a || a == e.a) && (!b || b == e.b) ? Side::same : Side::none;
    if (e.a != s.self && e.b != s.self) return Side::none;
    if (e.kind.has(EventKind::kPair)) {
      if (a && a != s.self) return Side::none;
      a = s.self;
    }
  }
  if ((!a || e.a == a) && (!b || e.b == b)) return Side::same;
  if (e.kind.has(EventKind::kPair) && (!a || e.b == a) && (!b || e.a == b)) return Side::swapped;
  return Side::none;
}

Subscription& subscribe(WorldRecord& record, EventKind kind, const EventFilter& filter, ObjectId self) {
  Subscriptions& subs = record.subscriptions;
  auto s = std::make_unique<Subscription>();
  s->id = subs.next_id++;
  s->kind = kind, s->filter = filter, s->self = self;
  Subscriptions::PerKind* per_kind = subs.find(kind);
  if (!per_kind) per_kind = &subs.kinds.emplace_back(kind);
  (self ? per_kind->object[self.slot] : per_kind->world).push_back(s.get());
  record.world->events().set_wanted(kind, true);
  subs.all.push_back(std::move(s));
  return *subs.all.back();
}

bool unsubscribe(lua_State* L, WorldRecord& record, std::uint64_t id) {
  for (auto& s : record.subscriptions.all) {
    if (s->id != id) continue;
    const bool was = s->live;
    if (was) forget_subscription(L, record, *s);
    return was;
  }
  return false;
}

void dispatch_events(lua_State* L, WorldRecord& record) {
  State& s = state(L);
  Subscriptions& subs = record.subscriptions;
  const auto& fresh = record.world->events().list();
  subs.events.assign(fresh.begin(), fresh.end());
  if (subs.all.empty()) return;
  luaL_checkstack(L, 10, "events");
  const std::uint64_t newest = subs.next_id - 1;
  push_data(L, record);
  const int data = lua_gettop(L);
  EventBlock& block = push_event(L, record);
  for (std::size_t i = 0; i < subs.events.size(); ++i) {
    const Event e = subs.events[i];
    find_matches(record, e, newest);
    std::vector<Subscription*> matches = std::move(subs.matches);
    for (Subscription* sub : matches) {
      if (!sub->live) continue;
      if (sub->task) {
        deliver_to_task(L, record, *sub, e);
        continue;
      }
      block.event = e;
      block.swapped = match(record, *sub, e) == Side::swapped;
      block.own = bool(sub->self);
      block.valid = true;
      lua_rawgeti(L, data, sub->function);
      lua_pushvalue(L, data + 1);
      s.call_handler(L, sub->profile, 1);
      block.valid = false;
    }
    subs.matches = std::move(matches);
  }
  lua_settop(L, data - 1);
  compact(L, record);
}

EventKind check_event_kind(lua_State* L, int index, const WorldRecord& record) {
  std::vector<EventKind> kinds(std::begin(kEventKinds), std::end(kEventKinds));
  for (const SystemDescriptor* d : record.world->catalog())
    kinds.insert(kinds.end(), d->events.begin(), d->events.end());
  std::vector<std::string> known;
  for (EventKind k : kinds) {
    if (lua_type(L, index) == LUA_TSTRING && lua_tostring(L, index) == std::string_view(k.text())) return k;
    known.emplace_back(k.text());
  }
  if (lua_type(L, index) != LUA_TSTRING) fail_here(L, "expected the name of an event, got " + describe(L, index));
  fail_here(L, "unknown event " + describe(L, index) + did_you_mean(lua_tostring(L, index), known) +
                   "; known: " + join(known));
}

struct FilterReading : EventFilter {
  WorldRecord* record = nullptr;
};

void read_tags(Options& o, const OptionRow& row, FilterReading& f) {
  std::vector<std::string> tags;
  if (!o.words(row.name, tags)) return;
  f.has_tags = true;
  for (const std::string& t : tags) f.tags |= f.record->world->objects().tag_bit(t);
}

template <auto Member>
constexpr Option<FilterReading> object_row(const char* name) {
  return special<FilterReading>(name, "object", [](Options& o, const OptionRow& row, FilterReading& f) {
    object_option(o, row.name, *f.record, f.*Member);
  });
}

void read_cause(Options& o, const OptionRow&, FilterReading& f) {
  std::vector<WakeCause> causes(std::begin(kWakeCauses), std::end(kWakeCauses));
  for (const SystemDescriptor* d : f.record->world->catalog())
    causes.insert(causes.end(), d->causes.begin(), d->causes.end());
  std::string names;
  for (WakeCause c : causes) names += (names.empty() ? "" : ", ") + std::string(c.text());
  if (std::size_t at = 0; o.choice("cause", names.c_str(), at)) f.cause = causes[at];
}

constexpr Option<FilterReading> kAnyFilter[] = {special("tag", kWordsType, read_tags),
                                                special("tags", kWordsType, read_tags),
                                                object_row<&EventFilter::object>("object")};
constexpr Option<FilterReading> kContactFilter[] = {
    object_row<&EventFilter::a>("a"),
    object_row<&EventFilter::b>("b"),
    field<&EventFilter::min_speed>("min_speed", "m/s", kNotNegative),
    field<&EventFilter::min_impulse>("min_impulse", "N s", kNotNegative),
    field<&EventFilter::min_slip>("min_slip", "m/s", kNotNegative),
};
constexpr Option<FilterReading> kSensorFilter[] = {object_row<&EventFilter::a>("sensor"),
                                                   object_row<&EventFilter::b>("other")};
constexpr Option<FilterReading> kBreakFilter[] = {field<&EventFilter::min_force>("min_force", "N", kNotNegative)};
constexpr Option<FilterReading> kWakeFilter[] = {special("cause", "string", read_cause),
                                                 object_row<&EventFilter::b>("other")};

// The rows that filters of such events have.
template <class F>
void each_filter(EventKind kind, F&& visit) {
  visit(kAnyFilter);
  if (kind.has(EventKind::kPair)) visit(kContactFilter);
  if (kind.has(EventKind::kSensed)) visit(kSensorFilter);
  if (kind.has(EventKind::kForce)) visit(kBreakFilter);
  if (kind.has(EventKind::kCause)) visit(kWakeFilter);
}

EventFilter read_filter(lua_State* L, int index, WorldRecord& record, EventKind kind) {
  FilterReading f;
  f.record = &record;
  Options o(L, index, std::string(function_name(L)) + "(\"" + kind.text() + "\")");
  each_filter(kind, [&](const auto& rows) { o.read_some(rows, f); });
  o.finish();
  return f;
}

void push_connection(lua_State* L, const WorldRecord& record, ConnectionKind kind, std::uint64_t id) {
  push_userdata(L, Class::connection, Connection{record.id, kind, id});
}

int push_subscription(lua_State* L, WorldRecord& record, ObjectId self) {
  const EventKind kind = check_event_kind(L, 2, record);
  if (self && kind.has(EventKind::kAlone)) fail_here(L, "objects have no 'step' event; use world:on");
  const bool has_filter = lua_gettop(L) >= 4 || lua_type(L, 3) == LUA_TTABLE;
  const int function = has_filter ? 4 : 3;
  EventFilter filter;
  if (has_filter && !lua_isnil(L, 3)) filter = read_filter(L, 3, record, kind);
  if (lua_type(L, function) != LUA_TFUNCTION)
    fail_here(L, "expected a function as handler, got " + describe(L, function));
  if (record.subscriptions.all.size() >= 1000000) fail_here(L, "expected at most a million subscriptions");
  const int key = keep(L, record, function);
  Subscription& s = subscribe(record, kind, filter, self);
  s.function = key;
  s.profile = state(L).profile_slot(L, function);
  push_connection(L, record, ConnectionKind::event, s.id);
  return 1;
}

int world_on(lua_State* L) { return push_subscription(L, check_world(L), {}); }

int world_events(lua_State* L) {
  WorldRecord& r = check_world(L);
  const EventKind kind = check_event_kind(L, 2, r);
  r.world->events().set_wanted(kind, true);  // from the next step on, for the kinds that cost something
  push(L, 0, kind.text(), r.world->step_count());
  push_event(L, r);
  lua_pushvalue(L, 1);
  lua_pushcclosure(L, guard<next_event>, 5);
  return 1;
}

void open_events(lua_State* L) {
  set_metamethods(
      L, Class::event,
      {{"__newindex", event_no_write}, {"__tostring", method<event_tostring>}, {"__pairs", guard<event_pairs>}});
  push_class(L, Class::event);
  lua_newtable(L);
  for (std::size_t i = 0; i < std::size(kFields); ++i) set_field(L, kFields[i].row.name, i + 1);
  push(L, guard<event_copy>);
  lua_pushcclosure(L, guard<event_index>, 2);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

std::vector<OptionInfo> event_filters(EventKind kind) {
  std::vector<OptionInfo> all;
  if (kind.has(EventKind::kAlone)) return all;
  each_filter(kind, [&](const auto& rows) { all = join_rows(std::move(all), describe_rows(rows)); });
  return all;
}

}  // namespace feder::lua
