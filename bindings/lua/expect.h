// Expectations of tests: what `check` gets as `expect`, and plain scripts as feder.expect. One that does not hold is
// reported with what was expected and what came, and the script goes on. Those with a largest simulated time step the
// world on until they hold or the time is over: the host owns stepping, a scene's check asks for it here alone.
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "lua/records.h"

namespace feder::lua {

// Counts an expectation that holds; reports one that does not, at the running line of the script. Returns `holds`.
bool expected(lua_State* L, bool holds, CheckFailure failure);
// "body \"crate3\": expected at most 0.01 m/s, got 2 m/s": the message of what has no other.
CheckFailure failure_of(std::string object, std::string wanted, std::string got, std::string tolerance = "",
                        std::string delta = "");

std::string point_text(const double* p);  // "(0, 1, 0)", to 1e-6
// Argument `index` as the largest simulated time to wait, s.
double time_argument(lua_State* L, int index, double otherwise);
// Steps the world on until holds() is true, for `within` s at most; what holds() says then.
bool wait_until(lua_State* L, WorldRecord& record, double within, const std::function<bool()>& holds);
// Counts instructions and raises the limits of a script that has steps made.
void charge_step(lua_State* L);
// The world that is tested; an error when there is none.
WorldRecord& tested_world(lua_State* L);
// Argument `index`, n or {least, most}.
struct CountRange {
  std::int64_t least = 0, most = 0;
  bool has(std::int64_t n) const { return n >= least && n <= most; }
  std::string text() const;  // "3", "1 to 9"
};
CountRange count_argument(lua_State* L, int index);

int expect_same_as(lua_State* L);  // may raise SceneError
void open_expect(lua_State* L);    // feder.expect, and State::expect_ref
std::span<const Method> expect_methods();
std::span<const Method> object_expectations();
std::span<const Method> place_expectations();
std::span<const Method> world_expectations();
std::vector<OptionInfo> budget_rows();

}  // namespace feder::lua
