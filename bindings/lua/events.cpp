// Events: matching, dispatch after the step, and the event object that handlers read.
#include "lua/events.h"

#include <algorithm>

#include "feder/profile.h"
#include "lua/records.h"

namespace feder::lua {
namespace {

bool is_contact(EventKind k) { return k.has(EventKind::kPair); }
bool is_sensor(EventKind k) { return k.has(EventKind::kSensed); }
bool is_source(EventKind k) { return k.has(EventKind::kAmount); }  // of an emitter or drain, and its fluid
bool has_two(EventKind k) { return k.has(EventKind::kPair | EventKind::kSensed); }

// What the event object reads from. Valid while its handler runs, or until its iterator moves on.
struct EventBlock {
  std::uint32_t world = 0;
  bool valid = false;
  bool turned = false;
  Event event;
};

enum Field : int {
  f_kind = 1,
  f_time,
  f_step,
  f_a,
  f_b,
  f_x,
  f_y,
  f_z,
  f_nx,
  f_ny,
  f_nz,
  f_impulse,
  f_slip,
  f_speed,
  f_object,
  f_cause,
  f_other,
  f_sensor,
  f_index,
  f_force,
  f_count,
  f_code,
  f_message,
  f_copy
};
const char* const kFields[] = {"kind",  "time",   "step",  "a",       "b",     "x",     "y",       "z",
                               "nx",    "ny",     "nz",    "impulse", "slip",  "speed", "object",  "cause",
                               "other", "sensor", "index", "force",   "count", "code",  "message", "copy"};

// Do contacts with that object tell where on it, under this name?
bool tells(lua_State* L, const WorldRecord& r, ObjectId id, std::string_view place) {
  const State& s = state(L);
  const ObjectClass* row = id ? class_row(s, class_of(s, r, id)) : nullptr;
  return row && row->place && place == row->place;
}

// Does the event tell about a point?
bool has_index(lua_State* L, const WorldRecord& r, const Event& e) {
  if (e.kind.has(EventKind::kPlace)) return true;
  return has_two(e.kind) && (tells(L, r, e.a, "index") || tells(L, r, e.b, "index"));
}

// Pushes a field, or nil when the event has none of that name.
void push_field(lua_State* L, WorldRecord& r, const Event& e, bool turned, int field) {
  const EventKind k = e.kind;
  const Real sign = turned ? Real(-1) : Real(1);
  const auto number = [&](bool present, double x) { present ? lua_pushnumber(L, x) : lua_pushnil(L); };
  const auto object = [&](bool present, ObjectId id) { present ? push_handle(L, r, id) : lua_pushnil(L); };
  switch (field) {
    case f_kind: lua_pushstring(L, k.text()); return;
    case f_time: lua_pushnumber(L, r.world->time()); return;
    case f_step: lua_pushinteger(L, static_cast<lua_Integer>(r.world->step_count())); return;
    case f_a: object(is_contact(k), turned ? e.b : e.a); return;
    case f_b: object(is_contact(k), turned ? e.a : e.b); return;
    case f_x:
    case f_y:
    case f_z: number(is_contact(k), e.point[field - f_x]); return;
    case f_nx:
    case f_ny:
    case f_nz: number(is_contact(k), sign * e.normal[field - f_nx]); return;
    case f_impulse: number(k.has(EventKind::kImpulse), e.impulse); return;
    case f_slip: number(k.has(EventKind::kSlip), e.slip); return;
    case f_speed: number(k.has(EventKind::kSpeed), e.speed); return;
    case f_object: object(!has_two(k) && !k.has(EventKind::kAlone), e.a); return;
    case f_cause: k.has(EventKind::kCause) ? (void)lua_pushstring(L, e.cause.text()) : lua_pushnil(L); return;
    case f_other: object(k.has(EventKind::kOther | EventKind::kSensed), e.b); return;
    case f_sensor: object(is_sensor(k), e.a); return;
    case f_index:
      has_index(L, r, e) ? lua_pushinteger(L, static_cast<lua_Integer>(e.index) + 1) : lua_pushnil(L);
      return;
    case f_force: number(k.has(EventKind::kForce), e.force); return;
    case f_count:
      if (is_source(k) || ((is_sensor(k) || is_contact(k)) && tells(L, r, e.b, "count")))
        lua_pushinteger(L, static_cast<lua_Integer>(e.index));
      else
        lua_pushnil(L);
      return;
    case f_code:
    case f_message:
      if (k.has(EventKind::kText) && e.text != kNone)
        lua_pushstring(
            L, (field == f_code ? r.world->events().warning_code(e) : r.world->events().warning_message(e)).c_str());
      else
        lua_pushnil(L);
      return;
    default: lua_pushnil(L);
  }
}

bool readable(lua_State* L, const EventBlock& block) { return block.valid && state(L).worlds[block.world]->world; }

int event_copy(lua_State* L) {
  const auto* block = static_cast<const EventBlock*>(test_class(L, 1, Class::event));
  if (!block) fail(L, "event:copy: expected an event before the ':', got " + describe(L, 1));
  if (!readable(L, *block)) fail(L, "event:copy: an event is valid inside its handler only; copy it there");
  push_event_copy(L, *state(L).worlds[block->world], block->event, block->turned);
  return 1;
}

int event_index(lua_State* L) {  // upvalues: table of fields, copy
  const auto* block = static_cast<const EventBlock*>(lua_touserdata(L, 1));
  lua_pushvalue(L, 2);
  lua_rawget(L, lua_upvalueindex(1));
  const int field = static_cast<int>(lua_tointeger(L, -1));
  if (field == 0) {
    const std::vector<std::string> known(std::begin(kFields), std::end(kFields));
    fail(L,
         "event: no field " + describe(L, 2) +
             (lua_type(L, 2) == LUA_TSTRING ? did_you_mean_or(lua_tostring(L, 2), known) : "; known: " + join(known)));
  }
  if (field == f_copy) {
    lua_pushvalue(L, lua_upvalueindex(2));
    return 1;
  }
  if (!readable(L, *block))
    fail(L, "event." + std::string(kFields[field - 1]) +
                ": an event is valid inside its handler only; keep it with e:copy()");
  push_field(L, *state(L).worlds[block->world], block->event, block->turned, field);
  return 1;
}

int event_no_write(lua_State* L) { fail(L, "event: an event cannot be changed; e:copy() gives a table"); }

int event_tostring(lua_State* L) {
  const auto* block = static_cast<const EventBlock*>(lua_touserdata(L, 1));
  lua_pushstring(L, block->valid ? (std::string("event ") + block->event.kind.text()).c_str() : "event (over)");
  return 1;
}

EventBlock& push_event(lua_State* L, const WorldRecord& record) {
  auto* block = static_cast<EventBlock*>(lua_newuserdatauv(L, sizeof(EventBlock), 0));
  new (block) EventBlock;
  block->world = record.id;
  push_class(L, Class::event);
  lua_setmetatable(L, -2);
  return *block;
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
  push_event_copy(L, record, e, match(record, s, e) == Side::turned);
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

int connection_disconnect(lua_State* L) {
  const auto* c = static_cast<const Connection*>(self_block(L));
  if (!c) wrong_self(L, "connection");
  WorldRecord& r = *state(L).worlds[c->world];
  bool was = false;
  if (r.world) was = c->kind == ConnectionKind::event ? unsubscribe(L, r, c->id) : cancel_timer(L, r, c->id);
  lua_pushboolean(L, was);
  return 1;
}

const Method kConnectionMethods[] = {
    {"disconnect", guard<connection_disconnect>, "c:disconnect() -> boolean",
     "ends a subscription or timer; false when it had ended"},
};
const Method kEventMethods[] = {
    {"copy", guard<event_copy>, "e:copy() -> table",
     "the event's fields in a table of their own, to keep after the handler"},
};

}  // namespace

std::span<const Method> event_methods() { return kEventMethods; }
std::span<const Method> connection_methods() { return kConnectionMethods; }

void push_event_copy(lua_State* L, WorldRecord& record, const Event& e, bool turned) {
  lua_newtable(L);
  for (int field = f_kind; field < f_copy; ++field) {
    push_field(L, record, e, turned, field);
    lua_setfield(L, -2, kFields[field - 1]);
  }
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
    if (is_contact(e.kind)) {
      if (a && a != s.self) return Side::none;
      a = s.self;
    }
  }
  if ((!a || e.a == a) && (!b || e.b == b)) return Side::same;
  if (is_contact(e.kind) && (!a || e.b == a) && (!b || e.a == b)) return Side::turned;
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
      block.turned = match(record, *sub, e) == Side::turned;
      block.valid = true;
      lua_rawgeti(L, data, sub->function);
      lua_pushvalue(L, data + 1);
      const std::size_t profile = sub->profile;
      const std::uint64_t start = clock_nanoseconds();
      Failure failure;
      const bool good = s.call(L, 1, 0, failure);
      block.valid = false;
      s.profile[profile].calls += 1;
      s.profile[profile].nanoseconds += clock_nanoseconds() - start;
      if (!good) s.report(failure);
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

EventFilter read_filter(lua_State* L, int index, WorldRecord& record, EventKind kind) {
  FilterReading f;
  f.record = &record;
  Options o(L, index, std::string(function_name(L)) + "(\"" + kind.text() + "\")");
  o.read_some(kAnyFilter, f);
  if (is_contact(kind)) o.read_some(kContactFilter, f);
  if (is_sensor(kind)) o.read_some(kSensorFilter, f);
  if (kind.has(EventKind::kForce)) o.read_some(kBreakFilter, f);
  if (kind.has(EventKind::kCause)) o.read_some(kWakeFilter, f);
  o.finish();
  return f;
}

void push_connection(lua_State* L, const WorldRecord& record, ConnectionKind kind, std::uint64_t id) {
  auto* c = static_cast<Connection*>(lua_newuserdatauv(L, sizeof(Connection), 0));
  *c = {record.id, kind, id};
  push_class(L, Class::connection);
  lua_setmetatable(L, -2);
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
  lua_pushinteger(L, 0);
  lua_pushstring(L, kind.text());
  lua_pushinteger(L, static_cast<lua_Integer>(r.world->step_count()));
  push_event(L, r);
  lua_pushvalue(L, 1);
  lua_pushcclosure(L, guard<next_event>, 5);
  return 1;
}

void open_events(lua_State* L) {
  push_class(L, Class::event);
  lua_newtable(L);
  for (int i = 0; i < static_cast<int>(std::size(kFields)); ++i) {
    lua_pushinteger(L, i + 1);
    lua_setfield(L, -2, kFields[i]);
  }
  lua_pushcfunction(L, guard<event_copy>);
  lua_pushcclosure(L, guard<event_index>, 2);
  lua_setfield(L, -2, "__index");
  lua_pushcfunction(L, event_no_write);
  lua_setfield(L, -2, "__newindex");
  lua_pushcfunction(L, event_tostring);
  lua_setfield(L, -2, "__tostring");
  lua_pop(L, 1);
}

}  // namespace feder::lua
