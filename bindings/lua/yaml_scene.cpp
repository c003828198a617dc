// Scenes written in YAML: the same keys as the Lua form, built by the same functions.
//   params:  { height: 10 } or { height: { value: 10, min: 1, max: 40 } }; "$height" stands for it anywhere below
//   bodies:  a list of body options; shape: { box: [1, 1, 1] } or { type: box, size: [1, 1, 1] };
//            repeat: { count: 10, step: [0, 1, 0] } makes copies, named name1, name2 ...
//   joints:  a and b are the names of bodies;  nets: as in world:net
//   check:   Lua text that sees world, scene and expect: what makes the scene a test
#include "lua/yaml_scene.h"

#include <algorithm>
#include <cmath>

#include "lua/options.h"
#include "lua/params.h"
#include "lua/sandbox.h"
#include "lua/scene.h"
#include "lua/shapes.h"
#include "lua/stack.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

const char* const kSceneKeys[] = {"title",  "seconds", "picture", "camera", "world",
                                  "params", "forces",  "check",   "golden", "random"};

// Raises an error at the table's line of the file, when it is known.
[[noreturn]] void fail_in(lua_State* L, int table, const std::string& message) {
  const std::string at = yaml_location(L, table);
  raise_error(L, at.empty() ? message : at + ": " + message);
}

// Replaces "$name" by the parameter's value in a deep copy of the value on top. YAML values have no cycles.
void fill_in(lua_State* L, int params) {
  luaL_checkstack(L, 10, "the YAML file is nested too deeply");
  if (lua_type(L, -1) == LUA_TSTRING) {
    const std::string text = lua_tostring(L, -1);
    if (text.size() < 2 || text[0] != '$') return;
    lua_getfield(L, params, text.c_str() + 1);
    if (lua_isnil(L, -1))
      lua_pop(L, 1);
    else
      lua_remove(L, -2);
    return;
  }
  if (lua_type(L, -1) != LUA_TTABLE) return;
  lua_newtable(L);
  copy_locations(L, -2, -1);
  for (lua_pushnil(L); lua_next(L, -3);) {
    fill_in(L, params);
    lua_pushvalue(L, -2);
    lua_insert(L, -2);
    lua_rawset(L, -4);
  }
  lua_remove(L, -2);
}

template <class F>
void each_of(lua_State* L, int scene, const char* key, F&& make) {
  if (lua_getfield(L, scene, key) != LUA_TNIL) {
    if (lua_type(L, -1) != LUA_TTABLE)
      fail_in(L, scene, std::string(key) + ": expected a list, got " + describe(L, -1));
    const int list = lua_gettop(L);
    for (lua_Integer i = 1; i <= static_cast<lua_Integer>(lua_rawlen(L, list)); ++i) {
      lua_rawgeti(L, list, i);
      if (lua_type(L, -1) != LUA_TTABLE)
        fail_in(L, list, std::string(key) + ": expected a list of tables, got " + describe(L, -1));
      make();
      lua_settop(L, list);
    }
  }
  lua_pop(L, 1);
}

int build_yaml(lua_State* L) {  // (world, scene); upvalue 1: the file's table, parameters filled in
  lua_settop(L, 1);
  lua_pushvalue(L, lua_upvalueindex(1));
  constexpr int world = 1, scene = 2;
  for (const Part* part : state(L).options.parts)
    for (const YamlList& list : part->yaml) each_of(L, scene, list.key, [&] { list.make(L, world); });
  each_of(L, scene, "forces", [&] { make_object(L, world, "force"); });
  return 0;
}

// Pushes the value of a parameter: feder.param(name, default, options), as the table at `params` has it under its name.
void declare_param(lua_State* L, int params, const std::string& name) {
  push_module(L);
  lua_getfield(L, -1, "param");
  lua_remove(L, -2);
  push(L, name);
  if (lua_getfield(L, params, name.c_str()) == LUA_TTABLE) {
    // { value: 10, min: 1 }: a copy without the value has the options
    lua_newtable(L);
    copy_locations(L, -2, -1);
    copy_fields(L, -2);
    lua_remove(L, -2);
    lua_getfield(L, -1, "value");
    if (lua_isnil(L, -1)) fail_in(L, -2, "params." + name + ": expected value: and min:, max:, ...");
    lua_pushnil(L);
    lua_setfield(L, -3, "value");
    lua_insert(L, -2);
  } else {
    lua_pushnil(L);
  }
  lua_call(L, 3, 1);
}

// Declares the parameters; leaves a table of their values.
void declare_params(lua_State* L, int scene) {
  lua_newtable(L);
  const int values = lua_gettop(L);
  if (lua_getfield(L, scene, "params") == LUA_TTABLE) {
    // ordered by name: the order of the file is not known here
    std::vector<std::string> names;
    for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1))
      if (lua_type(L, -2) == LUA_TSTRING) names.emplace_back(lua_tostring(L, -2));
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) {
      declare_param(L, values + 1, name);
      lua_setfield(L, values, name.c_str());
    }
  } else if (!lua_isnil(L, -1)) {
    fail_in(L, scene, "params: expected a table by name, got " + describe(L, -1));
  }
  lua_settop(L, values);
}

// Leaves the function of the check text, or nil. A text block starts in the line after its key.
void push_check(lua_State* L, int scene, const std::string& file) {
  if (lua_getfield(L, scene, "check") == LUA_TNIL) return;
  if (lua_type(L, -1) != LUA_TSTRING) fail_in(L, scene, "check: expected Lua text, got " + describe(L, -1));
  const std::string text = lua_tostring(L, -1);
  const std::string at = yaml_location(L, scene, "check");
  const int line = std::atoi(at.c_str() + at.rfind(':') + 1);
  const bool block = !text.empty() && text.back() == '\n';
  std::string code(static_cast<std::size_t>(std::max(0, block ? line : line - 1)), '\n');
  code += "local world, scene, expect = ... " + text;
  if (luaL_loadbufferx(L, code.data(), code.size(), ("@" + file).c_str(), "t") != LUA_OK) lua_error(L);
}

}  // namespace

std::vector<OptionInfo> yaml_param_rows() {
  return join_rows({{.row = {.name = "value"}, .type = "number, string or boolean", .fallback = "", .choices = ""}},
                   param_rows());
}

void copy_locations(lua_State* L, int from, int to) {
  from = lua_absindex(L, from), to = lua_absindex(L, to);
  if (lua_getfield(L, LUA_REGISTRYINDEX, "feder.places") == LUA_TTABLE) {
    lua_pushvalue(L, to);
    lua_pushvalue(L, from);
    lua_rawget(L, -3);
    lua_rawset(L, -3);
  }
  lua_pop(L, 1);
}

// An error at `table` when no shape has the name.
const ShapeKind& shape_kind_of(lua_State* L, int table, const std::string& name) {
  std::vector<std::string> known;
  for (const ShapeKind& kind : shape_kinds()) {
    if (name == kind.name) return kind;
    known.emplace_back(kind.name);
  }
  fail_in(L, table,
          name.empty() ? "shape: expected one of " + join(known)
                       : "shape: unknown shape '" + name + "'" + did_you_mean_or(name, known));
}

// Is a list behind the shape's name its one argument, and not the list of them?
bool takes_one_list(const ShapeKind& kind) {
  const auto needed = [](const ShapeArgument& a) { return std::isnan(a.fallback); };
  return !kind.arguments.empty() && kind.arguments[0].type >= ShapeArgumentType::points &&
         std::ranges::count_if(kind.arguments, needed) == 1;
}

// Pushes the first n values of the list on the stack in its place.
int spread(lua_State* L, int n) {
  const int list = lua_gettop(L);
  luaL_checkstack(L, n + 10, "shape");
  for (int i = 1; i <= n; ++i) lua_rawgeti(L, list, i);
  lua_remove(L, list);
  return n;
}

void push_named_argument(lua_State* L, int table, const ShapeArgument& a) {
  lua_getfield(L, table, a.name);
  if (a.type != ShapeArgumentType::surfaces || lua_isnil(L, -1)) return;
  lua_newtable(L);  // an option in Lua
  copy_locations(L, table, -1);
  lua_insert(L, -2);
  lua_setfield(L, -2, a.name);
}

// Pushes what { type =, radius = ... } says of the arguments, by their names; size = {w, h, d} for three sizes.
int push_named_arguments(lua_State* L, int table, const ShapeKind& kind) {
  int count = 0;
  if (lua_getfield(L, table, "size") == LUA_TTABLE)
    count = spread(L, static_cast<int>(std::min<lua_Unsigned>(lua_rawlen(L, -1), kind.arguments.size())));
  else
    lua_pop(L, 1);
  for (std::size_t k = static_cast<std::size_t>(count); k < kind.arguments.size(); ++k, ++count)
    push_named_argument(L, table, kind.arguments[k]);
  for (; count > 0 && lua_isnil(L, -1); --count) lua_pop(L, 1);
  return count;
}

// "plane", { box = {1, 1, 1} } or { type = "box", size = {1, 1, 1} } on the stack becomes the shape.
void make_shape(lua_State* L) {
  if (lua_type(L, -1) == LUA_TSTRING) {
    lua_newtable(L);
    lua_insert(L, -2);
    lua_setfield(L, -2, "type");
  }
  if (lua_type(L, -1) != LUA_TTABLE) return;  // the body's own reader complains
  // the name of the shape: under "type", or the one key
  const int table = lua_gettop(L);
  push_module(L);
  const bool typed = lua_getfield(L, table, "type") == LUA_TSTRING;
  std::string name;
  if (typed) {
    name = lua_tostring(L, -1);
  } else {
    lua_pop(L, 1), lua_pushnil(L);
    if (lua_next(L, table) && lua_type(L, -2) == LUA_TSTRING) name = lua_tostring(L, -2);
  }
  // its maker, and the arguments by name or as a list
  const ShapeKind& kind = shape_kind_of(L, table, name);
  const int maker = table + 1;
  lua_getfield(L, maker, kind.name);
  lua_replace(L, maker);
  int arguments = 1;
  if (kind.arguments.empty()) {  // one table of options: what is left of this one, or what the key holds
    if (typed) {
      lua_settop(L, maker);
      lua_pushnil(L), lua_setfield(L, table, "type");
      lua_pushvalue(L, table);
    } else {
      lua_remove(L, maker + 1);
    }
    if (lua_istable(L, -1)) make_shape_field(L, lua_gettop(L));
  } else if (typed) {
    lua_settop(L, maker);
    arguments = push_named_arguments(L, table, kind);
  } else {
    lua_remove(L, maker + 1);  // the key
    if (lua_type(L, -1) == LUA_TTABLE && !takes_one_list(kind))
      arguments = spread(L, static_cast<int>(std::min<lua_Unsigned>(lua_rawlen(L, -1), 100)));
  }
  // parts are shapes themselves
  if (!kind.arguments.empty() && kind.arguments[0].type == ShapeArgumentType::parts && lua_type(L, -1) == LUA_TTABLE)
    each_entry(L, -1, [&](lua_Integer) {
      if (lua_type(L, -1) == LUA_TTABLE) make_shape_field(L, lua_gettop(L));
    });
  lua_call(L, arguments, 1);
  lua_replace(L, table);
  lua_settop(L, table);
}

void make_shape_field(lua_State* L, int table) {
  if (lua_getfield(L, table, "shape") != LUA_TNIL) {
    make_shape(L);
    lua_setfield(L, table, "shape");
  } else {
    lua_pop(L, 1);
  }
}

void call_maker(lua_State* L, int object, const char* maker, int options, int results) {
  lua_getfield(L, object, maker);
  lua_pushvalue(L, object);
  lua_pushvalue(L, options);
  lua_call(L, 2, results);
}

void make_object(lua_State* L, int world, const char* maker) {
  const int options = lua_gettop(L);
  call_maker(L, world, maker, options, 0);
  lua_settop(L, options - 1);
}

void resolve_name(lua_State* L, int world, int options, const char* key) {
  if (lua_getfield(L, options, key) == LUA_TSTRING) {
    lua_getfield(L, world, "find");
    lua_pushvalue(L, world);
    lua_pushvalue(L, -3);
    lua_call(L, 2, 1);
    if (lua_isnil(L, -1)) fail_in(L, options, std::string(key) + ": no object is called " + describe(L, -2));
    lua_setfield(L, options, key);
  }
  lua_pop(L, 1);
}

void yaml_to_scene(lua_State* L, const std::string& file) {
  if (lua_type(L, -1) != LUA_TTABLE)
    fail(L, file + ": expected a scene with the keys title, world, bodies ..., got " + describe(L, -1));
  const int given = lua_gettop(L);
  Options o(L, given, "scene");
  for (const char* key : kSceneKeys) o.know(key);
  for (const Part* part : state(L).options.parts)
    for (const YamlList& list : part->yaml) o.know(list.key);
  misplace_world_options(o, state(L).options.systems, ": ");
  o.finish();
  declare_params(L, given);
  lua_pushvalue(L, given);
  fill_in(L, given + 1);
  const int scene = lua_gettop(L);
  lua_newtable(L);
  copy_locations(L, scene, -1);
  for (const char* key : {"title", "seconds", "picture", "camera", "world", "golden", "random"}) {
    lua_getfield(L, scene, key);
    lua_setfield(L, -2, key);
  }
  lua_pushvalue(L, scene);
  lua_pushcclosure(L, guard<build_yaml>, 1);
  lua_setfield(L, -2, "build");
  const int made = lua_gettop(L);
  push_check(L, scene, file);
  lua_setfield(L, made, "check");
  lua_settop(L, made);
  lua_replace(L, given);
  lua_settop(L, given);
}

}  // namespace feder::lua
