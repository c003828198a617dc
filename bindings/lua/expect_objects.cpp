// Expectations of objects: which they are; rest and sleep.
#include "lua/expect_objects.h"

#include <algorithm>
#include <cmath>

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
    moved = std::max(moved, std::hypot(points[i] - rest.from[i], points[i + 1] - rest.from[i + 1],
                                       points[i + 2] - rest.from[i + 2]));
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
  return expect_of_objects(
      L, Wait::within, within, "to settle", print_number(speed) + " m/s for " + print_number(kRestTime) + " s",
      [&](std::size_t k, Offender& offender) {
        if (asleep(L, -1)) return true;
        const double now = world.time(), was = rest_speed(L, now, speed, rests[k]);
        if (was >= 0) speeds[k] = was;
        offender.actual = speeds[k] < 0 ? "a moment too short to tell" : print_number(speeds[k]) + " m/s";
        return was >= 0 && now - rests[k].since >= kRestTime - 1e-9;
      });
}

// (object, [within])
int expect_asleep(lua_State* L) {
  return expect_of_objects(L, Wait::within, time_argument(L, 2, 0), "to sleep", "",
                           [&](std::size_t, Offender& offender) {
                             offender.actual = "it is awake";
                             return asleep(L, -1);
                           });
}

const Method kObjectExpectations[] = {
    {"settles", guard<expect_settles>, "expect.settles(object | {objects}, [within = 10], [speed = 0.01]) -> boolean",
     "asleep, or slower than speed (m/s) for 0.25 s, before `within` s are over"},
    {"asleep", guard<expect_asleep>, "expect.asleep(object | {objects}, [within = 0]) -> boolean",
     "sleeps before `within` s are over"},
};

}  // namespace

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

int expect_of_objects(lua_State* L, Wait wait, double seconds, const std::string& wanted, const std::string& tolerance,
                      const ObjectTest& passes) {
  WorldRecord& record = tested_objects(L);
  Offender first;
  const auto all_pass = [&] {
    bool all = true;
    first = {};
    each_entry(L, 1, [&](lua_Integer k) {
      check_object(L, -1, record, function_name(L));
      Offender offender;
      if (passes(static_cast<std::size_t>(k - 1), offender)) return;
      if (all) first = {describe(L, -1), offender.actual, offender.delta};
      all = false;
    });
    return all;
  };
  const bool holds = wait == Wait::within ? wait_until(L, record, seconds, all_pass)
                                          : !wait_until(L, record, seconds, [&] { return !all_pass(); });
  const std::string word = wait == Wait::within ? " within " : " during ";
  const std::string time = seconds > 0 ? word + print_number(seconds) + " s" : "";
  return push(L, expected(L, holds, failure_of(first.object, wanted + time, first.actual, tolerance, first.delta)));
}

std::span<const Method> object_expectations() { return kObjectExpectations; }

}  // namespace feder::lua
