// Studies: reads the table `study` of a scene, and asks its functions for references, errors and numbers.
#include "lua/study.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lua/buffer.h"
#include "lua/scene.h"
#include "lua/stack.h"

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

// { v1, v2, ... } or { from =, to =, factor = | step = }
std::vector<std::string> read_axis(lua_State* L, int index, const std::string& what) {
  std::vector<std::string> values;
  if (lua_type(L, index) != LUA_TTABLE)
    fail(L, what + ": expected a list or { from =, to =, factor = }, got " + describe(L, index));
  each_entry(L, index, [&](lua_Integer k) {
    values.push_back(axis_value(L, lua_gettop(L), what + "[" + std::to_string(k) + "]"));
  });
  if (!values.empty()) return values;
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

// All keys of the table at `index` but `methods`, by name.
StudyAxes read_axes(lua_State* L, int index, const std::string& what) {
  std::vector<std::string> names;
  for (lua_pushnil(L); lua_next(L, index) != 0; lua_pop(L, 1)) {
    if (lua_type(L, -2) != LUA_TSTRING) fail(L, what + ": expected names, got " + describe(L, -2));
    if (std::strcmp(lua_tostring(L, -2), "methods") != 0) names.push_back(lua_tostring(L, -2));
  }
  std::sort(names.begin(), names.end());
  StudyAxes axes;
  for (const std::string& name : names) {
    lua_getfield(L, index, name.c_str());
    axes.emplace_back(name, read_axis(L, lua_gettop(L), what + "." + name));
    lua_pop(L, 1);
  }
  return axes;
}

// After loading no line of the script runs: the location is that of the scene.
[[noreturn]] void complain(lua_State* L, const std::string& message) {
  raise_error(L, state(L).scene.where + ": " + message);
}

// Numbers of the value at `index`, depth first.
void collect(lua_State* L, int index, const std::string& what, int depth, std::vector<double>& out) {
  if (lua_type(L, index) == LUA_TNUMBER) {
    out.push_back(lua_tonumber(L, index));
    return;
  }
  if (const auto numbers = test_buffer(L, index); numbers.data()) {
    out.insert(out.end(), numbers.begin(), numbers.end());
    return;
  }
  if (lua_type(L, index) != LUA_TTABLE || depth > 8)
    complain(L, "study." + what + ": expected numbers or lists of numbers, got " + describe(L, index));
  each_entry(L, index, [&](lua_Integer) { collect(L, lua_gettop(L), what, depth + 1, out); });
}

void need_world(lua_State* L) {
  if (!state(L).current()) complain(L, "study: the scene has no world yet; build() makes it");
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

// A function whose second parameter is called `scene` is written like build and check: (world, scene, ...).
bool takes_scene(lua_State* L) {
  const char* const second = lua_getlocal(L, nullptr, 2);  // of the function on top
  return second && std::strcmp(second, "scene") == 0;
}

// Pushes study.<name>, or what that returns when it is a function: of (world, scene), references of (t, world, scene).
void push_value(lua_State* L, const char* name, double t) {
  push_part(L, name);
  if (lua_type(L, -1) != LUA_TFUNCTION) return;
  need_world(L);
  const bool timed = std::strcmp(name, "reference") == 0 || std::strcmp(name, "energy") == 0;
  const bool has_time = timed && !takes_scene(L);
  if (has_time) lua_pushnumber(L, t);
  push_scene_world(L);
  lua_call(L, has_time ? 3 : 2, 1);
}

// study.<key> = function
template <bool StudyDeclaration::*Has>
void read_function(Options& o, const OptionRow& row, StudyDeclaration& out) {
  out.*Has = o.push(row.name, LUA_TFUNCTION, "a function");
  if (out.*Has) lua_pop(o.L(), 1);
}

void read_energy(Options& o, const OptionRow& row, StudyDeclaration& out) {
  out.has_energy = o.push_any(row.name);
  if (!out.has_energy) return;
  if (lua_type(o.L(), -1) != LUA_TFUNCTION && lua_type(o.L(), -1) != LUA_TNUMBER)
    o.wrong(row.name, "a number or a function(t, world)");
  lua_pop(o.L(), 1);
}

void read_reference(Options& o, const OptionRow& row, StudyDeclaration& out) {
  using Reference = StudyDeclaration::Reference;
  lua_State* L = o.L();
  if (!o.push_any(row.name)) return;
  const int type = lua_type(L, -1);
  if (type == LUA_TFUNCTION)
    out.reference = takes_scene(L) ? Reference::stated : Reference::course;
  else if (type == LUA_TNUMBER || type == LUA_TTABLE)
    out.reference = Reference::stated;
  else if (type == LUA_TSTRING && std::strcmp(lua_tostring(L, -1), "self") == 0)
    out.reference = Reference::refined;
  else
    o.wrong(row.name, "numbers, \"self\" or a function(t, world)");
  lua_pop(L, 1);
}

void read_all_axes(Options& o, const OptionRow& row, StudyDeclaration& out) {
  if (!o.push(row.name, LUA_TTABLE, "a table of name = values")) return;
  out.axes = read_axes(o.L(), lua_gettop(o.L()), o.path(row.name));
  lua_pop(o.L(), 1);
}

constexpr Option<StudyDeclaration::Ladder> kLadder[] = {field<&StudyDeclaration::Ladder::methods>("methods")};

// { { dt = {..}, substeps = {..}, methods = {..} }, ... }
void read_ladders(Options& o, const OptionRow& row, StudyDeclaration& out) {
  lua_State* L = o.L();
  if (!o.push(row.name, LUA_TTABLE, "a list of tables of name = values")) return;
  each_entry(L, -1, [&](lua_Integer k) {
    const std::string what = o.path(row.name) + "[" + std::to_string(k) + "]";
    if (lua_type(L, -1) != LUA_TTABLE) fail(L, what + ": expected a table of name = values, got " + describe(L, -1));
    StudyDeclaration::Ladder ladder;
    Options(L, lua_gettop(L), what).read_some(kLadder, ladder);
    ladder.axes = read_axes(L, lua_gettop(L), what);
    out.ladders.push_back(std::move(ladder));
  });
  lua_pop(L, 1);
}

constexpr Option<StudyDeclaration> kScale[] = {
    field<&StudyDeclaration::length>("length", "m", kPositive).unset(),
    field<&StudyDeclaration::velocity>("velocity", "m/s", kPositive).unset(),
    field<&StudyDeclaration::energy>("energy", "J", kPositive).unset(),
};

constexpr Option<StudyDeclaration> kCertainty[] = {
    field<&StudyDeclaration::source>("source"),
    {{.name = "kind", .choices = "closed, quad, published"},
     "string",
     [](Options& o, const OptionRow& row, StudyDeclaration& out) {
       int index = 0;
       if (o.choice(row.name, row.choices, index)) o.text(row.name, out.kind);
     }},
    field<&StudyDeclaration::uncertainty>("uncertainty", "", kNotNegative),
    field<&StudyDeclaration::rounding>("rounding", "", kPositive),
    field<&StudyDeclaration::resolution>("resolution", "", kNotNegative),
};

template <auto& Rows>
void read_table(Options& o, const OptionRow& row, StudyDeclaration& out) {
  if (!o.push(row.name, LUA_TTABLE, "a table")) return;
  Options(o.L(), lua_gettop(o.L()), o.path(row.name)).read(Rows, out);
  lua_pop(o.L(), 1);
}

constexpr const char* kOfWorld = "function(world)";
constexpr Option<StudyDeclaration> kStudy[] = {
    special("error", "function(world, reference)", read_function<&StudyDeclaration::has_error>),
    special("reference", "numbers, \"self\" or function(t, world)", read_reference),
    special("observe", kOfWorld, read_function<&StudyDeclaration::has_observe>),
    special("measure", kOfWorld, read_function<&StudyDeclaration::has_measure>),
    special("energy", "number or function(t, world)", read_energy, "J"),
    special("event", kOfWorld, read_function<&StudyDeclaration::has_event>, "s"),
    special("constraint", kOfWorld, read_function<&StudyDeclaration::has_constraint>),
    field<&StudyDeclaration::conserves>("conserves"),
    {{.name = "scale"}, "table", read_table<kScale>, nullptr, rows_of<kScale>},
    {{.name = "certainty"}, "table", read_table<kCertainty>, nullptr, rows_of<kCertainty>},
    field<&StudyDeclaration::method>("method"),
    field<&StudyDeclaration::methods>("methods"),
    field<&StudyDeclaration::tolerance>("tolerance"),
    field<&StudyDeclaration::seconds>("seconds", "s", kPositive).unset(),
    {{.name = "axes"}, "tables or lists by name", read_all_axes, nullptr, rows_of<kAxis>},
    {{.name = "ladders"}, "list of tables", read_ladders, nullptr, rows_of<kLadder>},
    field<&StudyDeclaration::refined_substeps>("refined_substeps", "", {1, 1e6}).unset(),
    field<&StudyDeclaration::sweeps>("sweeps", "", kPositive),
    field<&StudyDeclaration::interpolate>("interpolate"),
};

}  // namespace

std::vector<OptionInfo> study_rows() { return describe_rows(kStudy); }

StudyDeclaration read_study(Options& scene) {
  StudyDeclaration out;
  if (!scene.push("study", LUA_TTABLE, "{ reference =, error =, axes =, ... }")) return out;
  lua_State* L = scene.L();
  out.declared = true;
  Options o(L, lua_gettop(L), scene.path("study"));
  o.read(kStudy, out);
  for (const std::string& word : out.conserves)
    if (word != "momentum" && word != "angular_momentum") o.wrong("conserves", "\"momentum\" or \"angular_momentum\"");
  lua_pop(L, 1);
  return out;
}

std::vector<double> read_study_numbers(lua_State* L, const char* name, double t) {
  std::vector<double> out;
  push_value(L, name, t);
  if (!lua_isnil(L, -1)) collect(L, lua_gettop(L), name, 0, out);
  return out;
}

StudyState read_study_state(lua_State* L, const char* name, double t) {
  push_value(L, name, t);
  const int value = lua_gettop(L);
  StudyState out;
  const std::pair<const char*, std::vector<double>*> parts[] = {{"x", &out.x}, {"v", &out.v}, {"q", &out.q}};
  bool named = false;
  for (const auto& [key, numbers] : parts) {
    if (lua_type(L, value) != LUA_TTABLE) break;
    lua_pushstring(L, key);
    if (lua_rawget(L, value) != LUA_TNIL) collect(L, lua_gettop(L), name, 0, *numbers), named = true;
    lua_pop(L, 1);
  }
  if (!named && !lua_isnil(L, value)) collect(L, value, name, 0, out.x);
  // whole points
  for (std::vector<double>* numbers : {&out.x, &out.v}) numbers->resize((numbers->size() + 2) / 3 * 3);
  return out;
}

double scene_error(lua_State* L, std::span<const double> refined) {
  need_world(L);
  const int base = lua_gettop(L);
  push_part(L, "error");
  if (lua_type(L, -1) != LUA_TFUNCTION) complain(L, "study.error: the scene declares none");
  // (world, reference, scene), or as build has it (world, scene, reference)
  const bool scene_second = takes_scene(L);
  push_scene_world(L);
  if (state(L).scene.study.reference == StudyDeclaration::Reference::refined) {
    push_list(L, refined, [&](double x) { push(L, x); });
  } else {
    push_value(L, "reference", state(L).current()->world->time());
  }
  if (!scene_second) lua_insert(L, -2);
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
