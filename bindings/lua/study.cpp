#include "lua/study.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "lua/scene.h"

namespace feder::lua {
namespace {

// A value of an axis as --set and --world take it.
std::string axis_value(lua_State* L, int index, const std::string& what) {
  if (lua_type(L, index) == LUA_TNUMBER) return print_number(check_number(L, index, what));
  if (lua_type(L, index) == LUA_TBOOLEAN) return lua_toboolean(L, index) ? "true" : "false";
  return check_text(L, index, what);
}

struct Axis {
  double from = 0, to = 0, factor = 0, step = 0;
};

constexpr Option<Axis> kAxis[] = {
    field<&Axis::from>("from").unset(),
    field<&Axis::to>("to").unset(),
    field<&Axis::factor>("factor", "", {1, 1e6, true}).unset(),
    field<&Axis::step>("step", "", kPositive).unset(),
};
std::vector<OptionInfo> axis_rows() { return describe_rows(kAxis); }

// { v1, v2, ... } or { from =, to =, factor = | step = }
std::vector<std::string> read_axis(lua_State* L, int index, const std::string& what) {
  std::vector<std::string> values;
  if (lua_type(L, index) != LUA_TTABLE)
    fail(L, what + ": expected a list or { from =, to =, factor = }, got " + describe(L, index));
  const auto n = static_cast<lua_Integer>(lua_rawlen(L, index));
  for (lua_Integer k = 1; k <= n; ++k) {
    lua_rawgeti(L, index, k);
    values.push_back(axis_value(L, lua_gettop(L), what + "[" + std::to_string(k) + "]"));
    lua_pop(L, 1);
  }
  if (n > 0) return values;
  Options o(L, index, what);
  Axis axis;
  o.read(kAxis, axis);
  const auto [from, to, factor, step] = axis;
  const bool multiplies = o.has("factor");
  if (!o.has("from")) o.wrong("from", "a number");
  if (!o.has("to")) o.wrong("to", "a number");
  if (!o.has("step") && !multiplies) o.wrong("step", "a number above 0, or factor");
  if (multiplies && !(from > 0 && to > 0)) o.raise(nullptr, "a range by factor expects from and to above 0");
  const bool up = to >= from;
  const double slack = 1e-9 * std::max(std::fabs(from), std::fabs(to));
  for (double x = from; up ? x <= to + slack : x >= to - slack;) {
    values.push_back(print_number(x));
    if (values.size() > 1000) o.raise(nullptr, "more than 1000 values");
    x = multiplies ? (up ? x * factor : x / factor) : (up ? x + step : x - step);
  }
  return values;
}

void read_axes(lua_State* L, int index, StudyDeclaration& out) {
  std::vector<std::string> names;
  for (lua_pushnil(L); lua_next(L, index) != 0; lua_pop(L, 1)) {
    if (lua_type(L, -2) != LUA_TSTRING) fail(L, "feder.scene.study.axes: expected names, got " + describe(L, -2));
    names.push_back(lua_tostring(L, -2));
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    lua_getfield(L, index, name.c_str());
    out.axes.emplace_back(name, read_axis(L, lua_gettop(L), "feder.scene.study.axes." + name));
    lua_pop(L, 1);
  }
}

// After loading no line of the script runs: the place is that of the scene.
[[noreturn]] void complain(lua_State* L, const std::string& message) {
  lua_pushstring(L, (state(L).scene.where + ": " + message).c_str());
  lua_error(L);
  std::abort();
}

// Numbers of the value at `index`, depth first.
void collect(lua_State* L, int index, int depth, std::vector<double>& out) {
  if (lua_type(L, index) == LUA_TNUMBER) {
    out.push_back(lua_tonumber(L, index));
    return;
  }
  if (lua_type(L, index) != LUA_TTABLE || depth > 8)
    complain(L, "study.reference: expected numbers or lists of numbers, got " + describe(L, index));
  const auto n = static_cast<lua_Integer>(lua_rawlen(L, index));
  for (lua_Integer k = 1; k <= n; ++k) {
    lua_rawgeti(L, index, k);
    collect(L, lua_gettop(L), depth + 1, out);
    lua_pop(L, 1);
  }
}

void need_world(lua_State* L) {
  const State& s = state(L);
  if (s.last_world >= s.worlds.size()) complain(L, "study: the scene has no world yet; build() makes it");
}

// Pushes study.<name>.
void push_part(lua_State* L, const char* name) {
  push_callback(L, "study");
  if (lua_type(L, -1) != LUA_TTABLE) {
    lua_pop(L, 1);
    lua_pushnil(L);
    return;
  }
  lua_pushstring(L, name);
  lua_rawget(L, -2);
  lua_remove(L, -2);
}

// Pushes what the reference is: the table, or what the function returns; nil when there is none.
void push_reference(lua_State* L) {
  push_part(L, "reference");
  if (lua_type(L, -1) != LUA_TFUNCTION) return;
  need_world(L);
  push_scene_world(L);
  lua_call(L, 2, 1);
}

void read_error(Options& o, const OptionRow& row, StudyDeclaration& out) {
  out.has_error = o.push(row.name, LUA_TFUNCTION, "a function(world, scene, reference)");
  if (out.has_error) lua_pop(o.L(), 1);
}

void read_reference(Options& o, const OptionRow& row, StudyDeclaration& out) {
  out.has_reference = o.push_any(row.name);
  if (!out.has_reference) return;
  if (lua_type(o.L(), -1) != LUA_TFUNCTION && lua_type(o.L(), -1) != LUA_TTABLE)
    o.wrong(row.name, "a table of numbers or a function(world, scene)");
  lua_pop(o.L(), 1);
}

void read_all_axes(Options& o, const OptionRow& row, StudyDeclaration& out) {
  if (!o.push(row.name, LUA_TTABLE, "a table of name = values")) return;
  read_axes(o.L(), lua_gettop(o.L()), out);
  lua_pop(o.L(), 1);
}

constexpr Option<StudyDeclaration> kStudy[] = {
    special("error", "function(world, scene, reference)", read_error),
    special("reference", "table of numbers or function(world, scene)", read_reference),
    field<&StudyDeclaration::method>("method"),
    {{.name = "axes"}, "table", read_all_axes, nullptr, axis_rows},
};

}  // namespace

std::vector<OptionInfo> study_rows() { return describe_rows(kStudy); }

StudyDeclaration read_study(Options& scene) {
  StudyDeclaration out;
  if (!scene.push("study", LUA_TTABLE, "{ reference =, error =, axes =, method = }")) return out;
  lua_State* L = scene.L();
  out.declared = true;
  Options o(L, lua_gettop(L), scene.path("study"));
  o.read(kStudy, out);
  lua_pop(L, 1);
  return out;
}

void push_scene_reference(lua_State* L, std::vector<double>& numbers) {
  push_reference(L);
  if (!lua_isnil(L, -1)) collect(L, lua_gettop(L), 0, numbers);
}

double scene_error(lua_State* L) {
  need_world(L);
  const int base = lua_gettop(L);
  push_part(L, "error");
  if (lua_type(L, -1) != LUA_TFUNCTION) complain(L, "study.error: the scene declares none");
  push_scene_world(L);
  push_reference(L);
  lua_call(L, 3, LUA_MULTRET);
  const int count = lua_gettop(L) - base;
  if (count == 0) complain(L, "study.error: expected one or more numbers, got nothing");
  double sum = 0;
  for (int k = 1; k <= count; ++k) {
    // an error may be infinite: a run that flew away
    if (lua_type(L, base + k) != LUA_TNUMBER)
      complain(L, "study.error: expected numbers, got " + describe(L, base + k));
    sum += lua_tonumber(L, base + k) * lua_tonumber(L, base + k);
  }
  return std::sqrt(sum / count);
}

}  // namespace feder::lua
