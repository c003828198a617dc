// Expectations that know physics: rest, sleep, place, events, energy, warnings. Objects are asked by their Lua methods,
// so that every kind that has them can be tested.
#include <algorithm>
#include <cmath>

#include "lua/expect.h"
#include "lua/object_points.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

constexpr double kRestTime = 0.25;   // s that what has settled stays within speed * kRestTime
constexpr double kRestSpeed = 0.01;  // m/s
constexpr double kSettleTime = 10;   // s

bool asleep(lua_State* L, int index) {
  if (!has_method(L, index, "awake")) return false;
  const int n = call_method_of(L, index, "awake");
  const bool awake = lua_toboolean(L, -1);
  lua_pop(L, n);
  return !awake;
}

// Argument 1, an object or a list of objects, as a list there; their world.
WorldRecord& tested_objects(lua_State* L) {
  const char* const what = function_name(L);
  if (lua_type(L, 1) != LUA_TTABLE) {
    lua_createtable(L, 1, 0);
    lua_pushvalue(L, 1);
    lua_rawseti(L, -2, 1);
    lua_replace(L, 1);
  }
  WorldRecord* record = nullptr;
  each_entry(L, 1, [&](lua_Integer) {
    const Handle* h = test_handle(L, -1);
    if (!h) fail_here(L, "expected an object of the world, got " + describe(L, -1));
    if (!record) record = state(L).worlds[h->world].get();
    check_object(L, -1, *record, what);
  });
  if (!record) fail_here(L, "expected an object or a list of objects, got an empty list");
  return *record;
}

// An object that does not do what is expected of it, and what it does.
struct Offender {
  std::string object, actual;
};
using ObjectTest = std::function<bool(std::size_t number, Offender& offender)>;  // of the object on top of the stack

// Waits until every object of argument 1 passes; the first that does not is reported.
int expect_of_objects(lua_State* L, double within, const std::string& wanted, const std::string& tolerance,
                      const ObjectTest& passes) {
  WorldRecord& record = tested_objects(L);
  Offender first;
  const bool holds = wait_until(L, record, within, [&] {
    bool all = true;
    first = {};
    each_entry(L, 1, [&](lua_Integer k) {
      check_object(L, -1, record, function_name(L));
      Offender offender;
      if (passes(static_cast<std::size_t>(k - 1), offender)) return;
      if (all) first = {describe(L, -1), offender.actual};
      all = false;
    });
    return all;
  });
  const std::string time = within > 0 ? " within " + print_number(within) + " s" : "";
  return push(L, expected(L, holds, failure_of(first.object, wanted + time, first.actual, tolerance)));
}

double distance(const double* a, const double* b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

std::string point_text(const double* p) {
  std::string text = "(";
  for (int k = 0; k < 3; ++k) text += (k ? ", " : "") + print_number(std::round(p[k] * 1e6) * 1e-6);
  return text + ")";
}

// Where an object was when its time of rest began.
struct Rest {
  Points from;
  double since = 0;  // s
};

// How fast the object on top has moved since then, m/s; a new time of rest begins where it has gone too far.
double rest_speed(lua_State* L, double now, double speed, Rest& rest) {
  Points points = points_of(L, -1, true);
  double moved = points.size() == rest.from.size() ? 0 : 1e30;
  for (std::size_t i = 0; moved < 1e30 && i + 2 < points.size(); i += 3)
    moved = std::max(moved, distance(&points[i], &rest.from[i]));
  const double elapsed = std::max(now - rest.since, 1e-9);
  if (!(moved <= speed * kRestTime)) rest.from = std::move(points), rest.since = now;
  return moved >= 1e30 ? -1 : moved / elapsed;
}

// (object, [within], [speed])
int expect_settles(lua_State* L) {
  const double within = time_argument(L, 2, kSettleTime);
  const double speed = lua_isnoneornil(L, 3) ? kRestSpeed : check_number(L, 3, function_name(L), kPositive);
  World& world = *tested_objects(L).world;
  std::vector<Rest> rests(lua_rawlen(L, 1));
  std::vector<double> speeds(rests.size(), -1);
  return expect_of_objects(L, within, "to settle", print_number(speed) + " m/s for " + print_number(kRestTime) + " s",
                           [&](std::size_t k, Offender& offender) {
                             if (asleep(L, -1)) return true;
                             const double now = world.time(), was = rest_speed(L, now, speed, rests[k]);
                             if (was >= 0) speeds[k] = was;
                             offender.actual =
                                 speeds[k] < 0 ? "a moment too short to tell" : print_number(speeds[k]) + " m/s";
                             return was >= 0 && now - rests[k].since >= kRestTime - 1e-9;
                           });
}

// (object, [within])
int expect_asleep(lua_State* L) {
  return expect_of_objects(L, time_argument(L, 2, 0), "to sleep", "", [&](std::size_t, Offender& offender) {
    offender.actual = "it is awake";
    return asleep(L, -1);
  });
}

// (object, {min, max}, [within]): all of its points
int expect_inside(lua_State* L) {
  const char* const name = function_name(L);
  if (lua_type(L, 2) != LUA_TTABLE) fail_here(L, "expected a box {min, max}, got " + describe(L, 2));
  Points corners;
  each_entry(L, 2, [&](lua_Integer) {
    const Vec3 v = check_vector(L, -1, name);
    for (int i = 0; i < 3; ++i) corners.push_back(static_cast<double>(v[i]));
  });
  if (corners.size() != 6) fail_here(L, "expected a box {min, max}: two points {x, y, z}");
  for (int i = 0; i < 3; ++i)
    if (corners[static_cast<std::size_t>(i)] > corners[static_cast<std::size_t>(i) + 3])
      std::swap(corners[static_cast<std::size_t>(i)], corners[static_cast<std::size_t>(i) + 3]);
  const std::string wanted = "inside " + point_text(&corners[0]) + " to " + point_text(&corners[3]);
  return expect_of_objects(L, time_argument(L, 3, 0), wanted, "", [&](std::size_t, Offender& offender) {
    const Points points = points_of(L, -1);
    for (std::size_t i = 0; i + 2 < points.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k)
        if (!(points[i + k] >= corners[k] && points[i + k] <= corners[k + 3])) {
          offender.actual =
              (points.size() > 3 ? "point " + std::to_string(i / 3 + 1) + " at " : "") + point_text(&points[i]);
          return false;
        }
    return true;
  });
}

// Numbers: (value, wanted, tolerance)
int expect_near_number(lua_State* L, double tolerance) {
  const double value = lua_tonumber(L, 1), wanted = check_number(L, 2, function_name(L));
  CheckFailure f{.expected = print_number(wanted), .actual = print_number(value), .tolerance = print_number(tolerance)};
  f.message = "expected " + f.expected + " within " + f.tolerance + ", got " + f.actual;
  return push(L, expected(L, std::abs(value - wanted) <= tolerance, f));
}

// (object, {x, y, z}, tolerance, [within]): the centre of its points
int expect_near(lua_State* L) {
  const double tolerance = check_number(L, 3, function_name(L), kNotNegative);
  if (lua_type(L, 1) == LUA_TNUMBER) return expect_near_number(L, tolerance);
  const Vec3 v = check_vector(L, 2, function_name(L));
  const double wanted[] = {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  return expect_of_objects(L, time_argument(L, 4, 0), "at " + point_text(wanted), print_number(tolerance) + " m",
                           [&](std::size_t, Offender& offender) {
                             const Points points = points_of(L, -1);
                             double center[3] = {0, 0, 0};
                             for (std::size_t i = 0; i < points.size(); ++i) center[i % 3] += points[i];
                             for (double& x : center) x /= std::max(1.0, static_cast<double>(points.size()) / 3);
                             offender.actual =
                                 point_text(center) + ", " + print_number(distance(center, wanted)) + " m away";
                             return !points.empty() && distance(center, wanted) <= tolerance;
                           });
}

// (kind, n | {least, most}, [within])
int expect_events(lua_State* L) {
  WorldRecord& record = tested_world(L);
  const EventKind kind = check_event_kind(L, 1, record);
  record.world->events().set_wanted(kind, true);
  std::int64_t range[2] = {0, 0};
  constexpr std::int64_t kMost = std::int64_t(1) << 53;
  if (lua_type(L, 2) == LUA_TTABLE) {
    if (lua_rawlen(L, 2) != 2) fail_here(L, "expected {least, most}");
    each_entry(L, 2, [&](lua_Integer k) { range[k - 1] = check_integer(L, -1, function_name(L), 0, kMost); });
  } else {
    range[0] = range[1] = check_integer(L, 2, function_name(L), 0, kMost);
  }
  const double within = time_argument(L, 3, 0);
  const auto count = [&] { return static_cast<std::int64_t>(record.observed.count(kind)); };
  wait_until(L, record, within, [&] { return count() >= std::max<std::int64_t>(1, range[0]); });
  const std::string wanted = std::to_string(range[0]) +
                             (range[0] == range[1] ? "" : " to " + std::to_string(range[1])) +
                             (within > 0 ? " within " + print_number(within) + " s" : "");
  return push(L, expected(L, count() >= range[0] && count() <= range[1],
                          failure_of(std::string(kind.text()) + " events", wanted, std::to_string(count()))));
}

double sum_of(const Energy& e) { return e.kinetic + e.potential + e.elastic; }

// (limit, [within]): against the energy before the first step, as a share of the largest of its parts
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

// ([code], [within])
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

const Method kPhysicsExpectations[] = {
    {"settles", guard<expect_settles>, "expect.settles(object | {objects}, [within = 10], [speed = 0.01]) -> boolean",
     "asleep, or slower than speed (m/s) for 0.25 s, before `within` s are over"},
    {"asleep", guard<expect_asleep>, "expect.asleep(object | {objects}, [within = 0]) -> boolean",
     "sleeps before `within` s are over"},
    {"inside", guard<expect_inside>, "expect.inside(object | {objects}, {min, max}, [within = 0]) -> boolean",
     "all of its points in the box"},
    {"near", guard<expect_near>, "expect.near(object | number, {x, y, z} | number, tolerance, [within = 0]) -> boolean",
     "the centre of its points at a place, or a number at another"},
    {"events", guard<expect_events>, "expect.events(kind, n | {least, most}, [within = 0]) -> boolean",
     "so many since the world was made; contact_stay (and hit in plain scripts) from the first call on"},
    {"energy_drift", guard<expect_energy_drift>, "expect.energy_drift(limit, [within = 0]) -> boolean",
     "of the sum of energies since the first step, as a share of the largest part"},
    {"no_warnings", guard<expect_no_warnings>, "expect.no_warnings([code], [within = 0]) -> boolean",
     "since the world was made, with that code or at all"},
};

}  // namespace

std::span<const Method> physics_expectations() { return kPhysicsExpectations; }

}  // namespace feder::lua
