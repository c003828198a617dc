// Expectations of a world: events, contacts, energy, momentum, penetration, warnings, hash.
#include <algorithm>
#include <cmath>

#include "lua/events.h"
#include "lua/expect_objects.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

std::string time_text(const char* word, double seconds) {
  return seconds > 0 ? std::string(" ") + word + " " + print_number(seconds) + " s" : "";
}

// True when holds() now and after every step for so long.
bool holds_during(lua_State* L, WorldRecord& record, double seconds, const std::function<bool()>& holds) {
  return !wait_until(L, record, seconds, [&] { return !holds(); });
}

// (kind, n | {least, most}, [within])
int expect_events(lua_State* L) {
  WorldRecord& record = tested_world(L);
  const EventKind kind = check_event_kind(L, 1, record);
  record.world->events().set_wanted(kind, true);
  const CountRange range = count_argument(L, 2);
  const double within = time_argument(L, 3, 0);
  const auto count = [&] { return static_cast<std::int64_t>(record.observed.count(kind)); };
  wait_until(L, record, within, [&] { return count() >= std::max<std::int64_t>(1, range.least); });
  return push(L, expected(L, range.has(count()),
                          failure_of(std::string(kind.text()) + " events", range.text() + time_text("within", within),
                                     std::to_string(count()))));
}

double sum_of(const Energy& e) { return e.kinetic + e.potential + e.elastic; }

// (limit, [during]): against the energy before the first step, as a share of the largest of its parts
int expect_energy_drift(lua_State* L) {
  const double limit = check_number(L, 1, function_name(L), kNotNegative);
  WorldRecord& record = tested_world(L);
  observe_start(*record.world, record.observed);
  double scale = 0, drift = 0;
  const auto look = [&](const Energy& e) {
    scale = std::max({scale, std::abs(e.kinetic), std::abs(e.potential), std::abs(e.elastic)});
    drift = std::max(drift, std::abs(sum_of(e) - sum_of(record.observed.start)));
    if (!std::isfinite(sum_of(e))) drift = sum_of(e);
  };
  look(record.observed.start), drift = 0;
  wait_until(L, record, time_argument(L, 2, 0), [&] {
    look(record.world->energy());
    return !std::isfinite(drift);
  });
  const double share = scale > 0 ? drift / scale : drift;
  return push(L, expected(L, share <= limit,
                          failure_of("energy", "a drift of at most " + print_number(limit), print_number(share),
                                     print_number(limit))));
}

// ([code], [during])
int expect_no_warnings(lua_State* L) {
  const std::string code = lua_isnoneornil(L, 1) ? "" : check_text(L, 1, function_name(L));
  WorldRecord& record = tested_world(L);
  const auto is_meant = [&](const Observed::Warning& w) { return code.empty() || w.code == code; };
  wait_until(L, record, time_argument(L, 2, 0),
             [&] { return std::ranges::any_of(record.observed.warnings, is_meant); });
  bool holds = true;
  for (const Observed::Warning& w : record.observed.warnings)
    if (is_meant(w))
      holds = expected(L, false,
                       failure_of("warnings", "none of '" + w.code + "'", std::to_string(w.count) + ": " + w.message));
  if (holds) expected(L, true, {});
  return push(L, holds);
}

// ([during]): now and, by what the world warned of, at all steps before
int expect_finite(lua_State* L) {
  WorldRecord& record = tested_world(L);
  const double during = time_argument(L, 1, 0);
  std::string got;
  const bool holds = holds_during(L, record, during, [&] {
    if (!record.world->is_finite()) got = "a number that is not";
    for (const Observed::Warning& w : record.observed.warnings)
      if (w.code == "non_finite") got = w.message;
    return got.empty();
  });
  return push(L, expected(L, holds, failure_of("state", "finite numbers" + time_text("during", during), got)));
}

// (limit, [during])
int expect_max_penetration(lua_State* L) {
  const double limit = check_number(L, 1, function_name(L), kNotNegative), during = time_argument(L, 2, 0);
  WorldRecord& record = tested_world(L);
  double now = 0;
  const bool holds = holds_during(L, record, during, [&] {
    push_world(L, record);
    now = lua_tonumber(L, -call_method_of(L, -1, "max_penetration"));
    lua_pop(L, 2);
    return now <= limit;
  });
  const std::string wanted = "at most " + print_number(limit) + " m" + time_text("during", during);
  return push(
      L, expected(L, holds,
                  failure_of("penetration", wanted, print_number(now) + " m", "", print_number(now - limit) + " m")));
}

// ({x, y, z}, tolerance, [during])
template <double (Momentum::*Part)[3]>
int expect_momentum(lua_State* L) {
  const bool linear = Part == &Momentum::linear;
  const std::string unit = linear ? " kg m/s" : " kg m2/s";
  const Vec3 v = check_vector(L, 1, function_name(L));
  const double wanted[] = {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  const double tolerance = check_number(L, 2, function_name(L), kNotNegative), during = time_argument(L, 3, 0);
  WorldRecord& record = tested_world(L);
  Momentum now;
  double off = 0;
  const bool holds = holds_during(L, record, during, [&] {
    now = record.world->momentum();
    const double* const p = now.*Part;
    off = std::hypot(p[0] - wanted[0], p[1] - wanted[1], p[2] - wanted[2]);
    return off <= tolerance;
  });
  return push(L,
              expected(L, holds,
                       failure_of(linear ? "momentum" : "angular momentum",
                                  point_text(wanted) + unit + time_text("during", during), point_text(now.*Part) + unit,
                                  print_number(tolerance) + unit, print_number(off) + unit)));
}

// The objects of an argument, an object or a list of objects; none for nil: any.
std::vector<ObjectId> objects_argument(lua_State* L, int index, WorldRecord& record) {
  std::vector<ObjectId> ids;
  if (lua_isnoneornil(L, index)) return ids;
  if (lua_type(L, index) != LUA_TTABLE) return {check_object(L, index, record, function_name(L))};
  each_entry(L, index, [&](lua_Integer) { ids.push_back(check_object(L, -1, record, function_name(L))); });
  if (ids.empty()) fail_here(L, "expected an object or a list of objects, got an empty list");
  return ids;
}

// A span of simulated time, s: all so far, and `within` s more, or {from, to}.
struct Window {
  double from = 0, to = 0;
  bool given = false;
};

Window window_argument(lua_State* L, int index, const World& world) {
  if (lua_type(L, index) != LUA_TTABLE) return {0, world.time() + time_argument(L, index, 0)};
  if (lua_rawlen(L, index) != 2) fail_here(L, "expected {from, to}, s");
  Window w{0, 0, true};
  each_entry(L, index,
             [&](lua_Integer k) { (k == 1 ? w.from : w.to) = check_number(L, -1, function_name(L), kNotNegative); });
  if (w.from > w.to) fail_here(L, "expected {from, to} with from at most to");
  return w;
}

std::string objects_text(lua_State* L, int index) {
  if (lua_isnoneornil(L, index)) return "anything";
  if (lua_type(L, index) != LUA_TTABLE) return describe(L, index);
  return "one of " + std::to_string(lua_rawlen(L, index)) + " objects";
}

// (a, [b], [{from, to} | within]): in contact at some moment of that time, or never
template <bool kWanted>
int expect_contact(lua_State* L) {
  const std::string subject = objects_text(L, 1);
  WorldRecord& record = tested_objects(L);
  const World& world = *record.world;
  const std::vector<Observed::Touch>& touches = record.observed.touches;
  const std::vector<ObjectId> a = objects_argument(L, 1, record), b = objects_argument(L, 2, record);
  const Window w = window_argument(L, 3, world);
  // a touch lasts from its first step to the one without it
  const auto is_of = [](const std::vector<ObjectId>& ids, ObjectId id) {
    return ids.empty() || std::ranges::find(ids, id) != ids.end();
  };
  const auto is_meant = [&](const Observed::Touch& t) {
    return t.begin <= w.to && t.end > w.from && w.from <= world.time() &&
           ((is_of(a, t.a) && is_of(b, t.b)) || (is_of(a, t.b) && is_of(b, t.a)));
  };
  const auto find = [&] { return std::ranges::find_if(touches, is_meant); };
  const bool touched = wait_until(L, record, w.to - world.time(), [&] { return find() != touches.end(); });
  if (!touched && touches.size() >= Observed::kMaxTouches) fail_here(L, "there were more contacts than are kept");
  // which one, and when
  std::string got = "none";
  if (touched) {
    const Objects& objects = world.objects();
    got = objects.describe(find()->a) + " on " + objects.describe(find()->b) + " from " + print_number(find()->begin) +
          " s on";
  }
  const std::string wanted = std::string(kWanted ? "contact" : "no contact") + " with " + objects_text(L, 2) +
                             " from " + print_number(w.from) + " to " + print_number(w.to) + " s";
  return push(L, expected(L, touched == kWanted, failure_of(subject, wanted, got)));
}

// (hash)
int expect_hash(lua_State* L) {
  const std::string wanted = check_text(L, 1, function_name(L));
  const std::string hash = hash_text(tested_world(L).world->hash());
  return push(L, expected(L, hash == wanted, failure_of("state", "hash " + wanted, hash)));
}

const Method kWorldExpectations[] = {
    {"events", guard<expect_events>, "expect.events(kind, n | {least, most}, [within = 0]) -> boolean",
     "so many since the world was made; contact_stay (and hit in plain scripts) from the first call on"},
    {"contact", guard<expect_contact<true>>,
     "expect.contact(a | {objects}, [b | {objects}], [{from, to} | within]) -> boolean",
     "in contact, with anything without b, at some moment from `from` to `to` (s), or since the world was made"},
    {"no_contact", guard<expect_contact<false>>,
     "expect.no_contact(a | {objects}, [b | {objects}], [{from, to} | during]) -> boolean",
     "at no moment of that time"},
    {"finite", guard<expect_finite>, "expect.finite([during = 0]) -> boolean",
     "every number of the state, since the world was made"},
    {"max_penetration", guard<expect_max_penetration>, "expect.max_penetration(limit, [during = 0]) -> boolean",
     "no two bodies overlap deeper, m"},
    {"energy_drift", guard<expect_energy_drift>, "expect.energy_drift(limit, [during = 0]) -> boolean",
     "of the sum of energies since the first step, as a share of the largest part"},
    {"momentum", guard<expect_momentum<&Momentum::linear>>,
     "expect.momentum({x, y, z}, tolerance, [during = 0]) -> boolean", "of the world, kg m/s"},
    {"angular_momentum", guard<expect_momentum<&Momentum::angular>>,
     "expect.angular_momentum({x, y, z}, tolerance, [during = 0]) -> boolean", "about the origin, kg m2/s"},
    {"no_warnings", guard<expect_no_warnings>, "expect.no_warnings([code], [during = 0]) -> boolean",
     "since the world was made, with that code or at all"},
    {"hash", guard<expect_hash>, "expect.hash(hash) -> boolean", "of the state, as world:hash() gives it"},
    {"same_as", guard<expect_same_as>, "expect.same_as{ KEY = value, ... } -> boolean",
     "the hash of another run of the scene, with these options of the world: { threads = 4 }"},
};

}  // namespace

std::span<const Method> world_expectations() { return kWorldExpectations; }

}  // namespace feder::lua
