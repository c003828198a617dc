#include "lua/sandbox.h"

#include <cmath>
#include <cstring>

#include "base/trig.h"
#include "lua/objects.h"

namespace feder::lua {
namespace {

int lua_print(lua_State* L) {
  const int count = lua_gettop(L);
  std::string line;
  for (int i = 1; i <= count; ++i) {
    push_text(L, i);
    std::size_t size = 0;
    const char* text = lua_tolstring(L, -1, &size);
    if (i > 1) line += '\t';
    line.append(text, size);
    lua_pop(L, 1);
  }
  // terminal escapes stay text
  for (char& c : line)
    if ((static_cast<unsigned char>(c) < 32 && c != '\t' && c != '\n') || c == 127) c = '?';
  line += '\n';
  charge(L, line.size());
  State& s = state(L);
  s.printed += line.size();
  if (s.options.output_limit > 0 && s.printed > s.options.output_limit) s.trip(L, Limit::output);
  s.print(line);
  return 0;
}

int lua_tostring_safe(lua_State* L) {
  luaL_checkany(L, 1);
  push_text(L, 1);
  return 1;
}

// A full collection when asked; the pace of the collector is the host's, and what changes it does nothing.
int lua_collectgarbage(lua_State* L) {
  static const char* const kWhat[] = {"collect",      "count",       "stop",     "restart",    "step", "isrunning",
                                      "generational", "incremental", "setpause", "setstepmul", nullptr};
  const int what = luaL_checkoption(L, 1, "collect", kWhat);
  State& s = state(L);
  switch (what) {
    case 0:
      charge(L, s.memory_used / 16);
      lua_gc(L, LUA_GCCOLLECT, 0);
      lua_pushinteger(L, 0);
      break;
    case 1: lua_pushinteger(L, static_cast<lua_Integer>(s.memory_used / 1024)); break;
    case 4:  // a cycle has ended: a loop until it has ends too
    case 5: lua_pushboolean(L, 1); break;
    case 6:
    case 7: lua_pushstring(L, "incremental"); break;
    case 8: lua_pushinteger(L, 200); break;
    case 9: lua_pushinteger(L, 100); break;
    default: lua_pushinteger(L, 0);
  }
  return 1;
}

// Uniform in [lo, hi], without the bias of a plain remainder.
lua_Integer random_between(Rng& rng, lua_Integer lo, lua_Integer hi) {
  const std::uint64_t range = static_cast<std::uint64_t>(hi) - static_cast<std::uint64_t>(lo);
  const auto next = [&rng] {
    const std::uint64_t high = rng.next();
    return high << 32 | rng.next();
  };
  if (range == ~std::uint64_t(0)) return static_cast<lua_Integer>(next());
  const std::uint64_t count = range + 1, limit = ~std::uint64_t(0) - (~std::uint64_t(0) % count + 1) % count;
  std::uint64_t x = next();
  while (x > limit) x = next();
  return static_cast<lua_Integer>(static_cast<std::uint64_t>(lo) + x % count);
}

int math_random(lua_State* L) {
  Rng& rng = state(L).random();
  switch (lua_gettop(L)) {
    case 0: lua_pushnumber(L, rng.unit53()); return 1;
    case 1: {
      const lua_Integer hi = luaL_checkinteger(L, 1);
      if (hi == 0) {  // all bits
        lua_pushinteger(L, random_between(rng, LUA_MININTEGER, LUA_MAXINTEGER));
        return 1;
      }
      if (hi < 1) fail(L, "math.random: expected a whole number of at least 1, got " + describe(L, 1));
      lua_pushinteger(L, random_between(rng, 1, hi));
      return 1;
    }
    case 2: {
      const lua_Integer lo = luaL_checkinteger(L, 1), hi = luaL_checkinteger(L, 2);
      if (lo > hi) fail(L, "math.random: expected lo at most hi, got " + describe(L, 1) + ", " + describe(L, 2));
      lua_pushinteger(L, random_between(rng, lo, hi));
      return 1;
    }
    default: fail(L, "math.random: expected at most two numbers");
  }
}

// randomseed(): the next seed that the generator itself gives, so runs repeat; randomseed(x [, y]): all bits of both.
// Returns the two integers that give the same sequence again.
int math_randomseed(lua_State* L) {
  Rng& rng = state(L).random();
  lua_Integer seed = 0, stream = 0;
  if (lua_isnone(L, 1)) {
    seed = random_between(rng, LUA_MININTEGER, LUA_MAXINTEGER);
    stream = random_between(rng, 1, LUA_MAXINTEGER);
  } else {
    const lua_Number x = luaL_checknumber(L, 1);
    if (!std::isfinite(x)) fail(L, "math.randomseed: expected a finite number, got " + describe(L, 1));
    int whole = 0;
    seed = lua_tointegerx(L, 1, &whole);
    if (!whole) std::memcpy(&seed, &x, sizeof seed);
    stream = luaL_optinteger(L, 2, 0);
  }
  // without a second number, the sequences of Rng(seed)
  constexpr std::uint64_t kStream = 54;
  rng = Rng(static_cast<std::uint64_t>(seed), kStream ^ static_cast<std::uint64_t>(stream));
  lua_pushinteger(L, seed);
  lua_pushinteger(L, stream);
  return 2;
}

// The runtime's own: the same on every machine.
template <double (*F)(double)>
int math_wave(lua_State* L) {
  lua_pushnumber(L, F(luaL_checknumber(L, 1)));
  return 1;
}

void make_classes(lua_State* L) {
  using List = std::span<const Method>;
  const State& s = state(L);
  const List force[] = {object_methods(), force_methods()};
  make_class(L, Class::force, force);
  const List object[] = {object_methods()};
  make_class(L, Class::object, object);
  for (std::size_t i = 0; i < s.object_classes.size(); ++i) {
    const List own[] = {object_methods(), s.object_classes[i]->methods};
    make_class(L, static_cast<Class>(kOwnClasses + static_cast<int>(i)), own);
  }
  std::vector<List> world = {world_methods()};
  for (const Part* part : s.options.parts) world.push_back(part->world);
  make_class(L, Class::world, world);
  open_classes(L);
}

int make_weak_table(lua_State* L, const char* mode) {
  lua_newtable(L);
  lua_newtable(L);
  lua_pushstring(L, mode);
  lua_setfield(L, -2, "__mode");
  lua_setmetatable(L, -2);
  return luaL_ref(L, LUA_REGISTRYINDEX);
}

void remove_globals(lua_State* L, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    lua_pushnil(L);
    lua_setglobal(L, name);
  }
}

void set_field(lua_State* L, const char* table, const char* name, lua_CFunction f) {
  lua_getglobal(L, table);
  if (f)
    lua_pushcfunction(L, f);
  else
    lua_pushnil(L);
  lua_setfield(L, -2, name);
  lua_pop(L, 1);
}

}  // namespace

lua_Integer value_id(lua_State* L, int index) {
  index = lua_absindex(L, index);
  State& s = state(L);
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.ids_ref);
  lua_pushvalue(L, index);
  lua_rawget(L, -2);
  lua_Integer id = lua_tointeger(L, -1);
  lua_pop(L, 1);
  if (id == 0) {
    id = ++s.next_id;
    lua_pushvalue(L, index);
    lua_pushinteger(L, id);
    lua_rawset(L, -3);
  }
  lua_pop(L, 1);
  return id;
}

void push_text(lua_State* L, int index) {
  index = lua_absindex(L, index);
  if (luaL_callmeta(L, index, "__tostring")) {
    if (lua_type(L, -1) != LUA_TSTRING) fail(L, "'__tostring' must return a string");
    return;
  }
  switch (lua_type(L, index)) {
    case LUA_TNIL:
    case LUA_TBOOLEAN:
    case LUA_TNUMBER:
    case LUA_TSTRING: luaL_tolstring(L, index, nullptr); return;
    default: break;
  }
  std::string name = luaL_typename(L, index);
  const int type = luaL_getmetafield(L, index, "__name");
  if (type == LUA_TSTRING) name = lua_tostring(L, -1);
  if (type != LUA_TNIL) lua_pop(L, 1);
  lua_pushstring(L, (name.substr(0, 100) + ": #" + std::to_string(value_id(L, index))).c_str());
}

int open_sandbox(lua_State* L) {
  State& s = state(L);
  luaL_requiref(L, "_G", luaopen_base, 1);
  luaL_requiref(L, "table", luaopen_table, 1);
  luaL_requiref(L, "string", luaopen_string, 1);
  luaL_requiref(L, "math", luaopen_math, 1);
  luaL_requiref(L, "utf8", luaopen_utf8, 1);
  luaL_requiref(L, "coroutine", luaopen_coroutine, 1);
  lua_settop(L, 0);
  remove_globals(L, {"dofile", "loadfile", "load", "warn", "collectgarbage", "print", "tostring"});
  set_field(L, "string", "dump", nullptr);
  set_field(L, "math", "random", guard<math_random>);
  set_field(L, "math", "randomseed", guard<math_randomseed>);
  set_field(L, "math", "sin", math_wave<sine>);
  set_field(L, "math", "cos", math_wave<cosine>);
  set_field(L, "math", "tan", math_wave<tangent>);
  lua_register(L, "print", guard<lua_print>);
  lua_register(L, "tostring", guard<lua_tostring_safe>);
  lua_register(L, "collectgarbage", guard<lua_collectgarbage>);

  s.worlds_ref = make_weak_table(L, "v");
  s.ids_ref = make_weak_table(L, "k");
  lua_newtable(L);
  // files written for stock Lua begin with local string = require "string"
  for (const char* name : {"_G", "table", "string", "math", "utf8", "coroutine"}) {
    lua_getglobal(L, name);
    lua_setfield(L, -2, name);
  }
  s.modules_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  lua_newtable(L);
  s.params_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  open_protected(L);
  open_ordered(L);
  open_text(L);
  make_classes(L);
  open_module(L);

  // one script cannot change the strings of another
  lua_pushstring(L, "");
  lua_getmetatable(L, -1);
  lua_pushboolean(L, 0);
  lua_setfield(L, -2, "__metatable");
  lua_settop(L, 0);
  return 0;
}

}  // namespace feder::lua
