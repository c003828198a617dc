// The table `expect`: conditions, comparisons and budgets, and how expectations wait.
#include "lua/expect.h"

#include <cmath>
#include <optional>

#include "lua/sandbox.h"
#include "lua/stack.h"
#include "lua/step.h"

namespace feder::lua {
namespace {

constexpr std::size_t kMaxFailures = 10000;  // that are kept of one script
constexpr double kMaxWait = 3600;            // s

int expect_condition(lua_State* L) {  // (expect, condition, [message])
  lua_remove(L, 1);
  luaL_checkany(L, 1);
  std::string message = "expectation failed";
  if (!lua_toboolean(L, 1) && !lua_isnoneornil(L, 2)) {
    lua_getglobal(L, "tostring");
    lua_pushvalue(L, 2);
    lua_call(L, 1, 1);
    message = lua_isstring(L, -1) ? lua_tostring(L, -1) : "?";
  }
  expected(L, lua_toboolean(L, 1), {.message = message});
  lua_settop(L, 1);
  return 1;
}

struct Comparison {
  const char* sign;
  bool (*holds)(double value, double bound);
};
constexpr Comparison kComparisons[] = {
    {"<", [](double x, double y) { return x < y; }},
    {"<=", [](double x, double y) { return x <= y; }},
    {">", [](double x, double y) { return x > y; }},
    {">=", [](double x, double y) { return x >= y; }},
};

// expect.error(value, "<", 1e-3, [what]): NaN holds against nothing.
int expect_error(lua_State* L) {
  if (lua_type(L, 1) != LUA_TNUMBER) fail_here(L, "expected a number, got " + describe(L, 1));
  const double value = lua_tonumber(L, 1);
  const std::string sign = check_text(L, 2, "expect.error: comparison");
  const double bound = check_number(L, 3, "expect.error: bound");
  const std::string what = lua_isnoneornil(L, 4) ? "error" : check_text(L, 4, "expect.error: message");
  for (const Comparison& c : kComparisons) {
    if (sign != c.sign) continue;
    CheckFailure f{.expected = sign + " " + print_number(bound),
                   .actual = print_number(value),
                   .delta = print_number(value - bound)};
    f.message = what + ": expected " + f.expected + ", got " + f.actual;
    return push(L, expected(L, c.holds(value, bound), f));
  }
  fail_here(L, "expected \"<\", \"<=\", \">\" or \">=\", got '" + sign + "'");
}

struct Budget {
  double instructions = 0, ms = 0;  // per step
};
constexpr Option<Budget> kBudget[] = {
    field<&Budget::instructions>("instructions", "", kPositive).unset(),
    field<&Budget::ms>("ms", "ms", kPositive).unset(),
};

// Instructions are the same everywhere: a failure. Milliseconds are the machine's: a note.
int expect_budget(lua_State* L) {
  Budget budget;
  Options o(L, 1, "expect.budget");
  o.read(kBudget, budget);
  State& s = state(L);
  World& world = *tested_world(L).world;
  const double steps = static_cast<double>(std::max<std::uint64_t>(1, world.step_count()));
  bool holds = true;
  if (o.has("instructions")) {
    const double used = static_cast<double>(s.handler_instructions) / steps;
    holds = expected(L, used <= budget.instructions,
                     failure_of("scripts", "at most " + print_number(budget.instructions) + " instructions per step",
                                print_number(used)));
  }
  if (o.has("ms")) {
    const double used = static_cast<double>(world.plan().total_nanoseconds()) * 1e-6 / steps;
    if (used > budget.ms) {
      CheckFailure f = failure_of("step", "at most " + print_number(budget.ms) + " ms", print_number(used) + " ms");
      f.where = location(L);
      s.checks.notes.push_back(f);
    }
  }
  return push(L, holds);
}

const Method kExpectations[] = {
    {"error", guard<expect_error>, "expect.error(value, \"<\" | \"<=\" | \">\" | \">=\", bound, [what]) -> boolean",
     "a comparison whose numbers are reported"},
    {"budget", guard<expect_budget>, "expect.budget{ instructions =, ms = } -> boolean",
     "of a step: Lua instructions of its handlers; ms are noted and fail nothing", budget_rows},
};

// While a check waits, steps run in their own phase and with their own budget.
class OwnPhase {
 public:
  explicit OwnPhase(State& s) : state_(s), phase_(s.phase), budget_(s.budget) {
    s.phase = Phase::running, s.budget = s.allowed_instructions(), s.lua_start = 0;
  }
  ~OwnPhase() { state_.phase = phase_, state_.budget = budget_, state_.lua_start = 0; }
  OwnPhase(const OwnPhase&) = delete;
  OwnPhase& operator=(const OwnPhase&) = delete;

 private:
  State& state_;
  Phase phase_;
  std::uint64_t budget_;
};

void step_on(lua_State* L, WorldRecord& record) {
  State& s = state(L);
  charge_step(L);
  std::optional<OwnPhase> phase;
  if (s.is_scene) phase.emplace(s);
  run_step(L, record);
  phase.reset();
  if (s.on_step) s.on_step(*record.world);
}

// The name by which the script calls the running function.
std::string called_name(lua_State* L) {
  lua_Debug ar;
  if (!lua_getstack(L, 0, &ar) || !lua_getinfo(L, "n", &ar)) return {};
  const std::string full = function_name(L);
  return ar.name ? ar.name : full.substr(full.rfind('.') + 1);
}

}  // namespace

bool expected(lua_State* L, bool holds, CheckFailure failure) {
  State& s = state(L);
  if (holds) {
    ++s.checks.passed;
    return true;
  }
  failure.where = location(L), failure.call = called_name(L);
  if (const WorldRecord* r = s.current(); r && r->world)
    failure.time = r->world->time(), failure.step = r->world->step_count();
  // a check returns its failures; others are reported like errors of handlers, and the script goes on
  if (s.phase != Phase::checking) s.report({.where = failure.where, .message = failure.message, .expectation = true});
  if (s.checks.failures.size() < kMaxFailures) s.checks.failures.push_back(std::move(failure));
  return false;
}

CheckFailure failure_of(std::string object, std::string wanted, std::string got, std::string tolerance,
                        std::string delta) {
  CheckFailure f;
  f.message = object + ": expected " + wanted + ", got " + got;
  f.object = std::move(object), f.expected = std::move(wanted), f.actual = std::move(got);
  f.tolerance = std::move(tolerance), f.delta = std::move(delta);
  return f;
}

std::string point_text(const double* p) {
  std::string text = "(";
  for (int k = 0; k < 3; ++k) text += (k ? ", " : "") + print_number(std::round(p[k] * 1e6) * 1e-6);
  return text + ")";
}

double time_argument(lua_State* L, int index, double otherwise) {
  return lua_isnoneornil(L, index) ? otherwise : check_number(L, index, function_name(L), {0, kMaxWait});
}

bool wait_until(lua_State* L, WorldRecord& record, double within, const std::function<bool()>& holds) {
  if (within <= 0) return holds();
  const State& s = state(L);
  const bool may_step = s.phase == Phase::checking || (!s.is_scene && s.phase == Phase::loading);
  if (record.busy || s.task_world == &record || !may_step)
    fail_here(L, "only checks and plain scripts may wait; here the time must be 0");
  const auto steps = static_cast<std::uint64_t>(std::llround(within / static_cast<double>(record.world->desc().dt)));
  for (std::uint64_t i = 0; i < steps; ++i) {
    if (holds()) return true;
    step_on(L, record);
  }
  return holds();
}

void charge_step(lua_State* L) { charge(L, 100); }

std::string CountRange::text() const {
  return std::to_string(least) + (least == most ? "" : " to " + std::to_string(most));
}

CountRange count_argument(lua_State* L, int index) {
  constexpr std::int64_t kMost = std::int64_t(1) << 53;
  const auto read = [&](int at) { return check_integer(L, at, function_name(L), 0, kMost); };
  if (lua_type(L, index) != LUA_TTABLE) return {read(index), read(index)};
  if (lua_rawlen(L, index) != 2) fail_here(L, "expected n or {least, most}");
  CountRange range;
  each_entry(L, index, [&](lua_Integer k) { (k == 1 ? range.least : range.most) = read(-1); });
  return range;
}

WorldRecord& tested_world(lua_State* L) {
  WorldRecord* const r = state(L).current();
  if (!r || !r->world) fail_here(L, "there is no world");
  return *r;
}

void open_expect(lua_State* L) {
  push_module(L);
  lua_newtable(L);
  add_methods(L, kExpectations, "expect.", 0);
  for (const auto rows : {object_expectations(), place_expectations(), world_expectations()})
    add_methods(L, rows, "expect.", 0);
  lua_newtable(L);
  set_field(L, "__call", expect_condition);
  refuse_unknown(L, "expect");
  set_field(L, "__metatable", false);
  lua_setmetatable(L, -2);
  lua_pushvalue(L, -1);
  state(L).expect_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  lua_setfield(L, -2, "expect");
  lua_pop(L, 1);
}

std::span<const Method> expect_methods() { return kExpectations; }
std::vector<OptionInfo> budget_rows() { return describe_rows(kBudget); }

}  // namespace feder::lua
