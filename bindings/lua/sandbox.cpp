// The sandbox: which of the standard library scripts see, and what takes the place of the rest.
#include "lua/sandbox.h"

#include <cmath>
#include <cstring>

#include "base/trig.h"
#include "lua/expect.h"
#include "lua/objects.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

int lua_print(lua_State* L) {
  std::string line = text_of_values(L, 1);
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
      return push(L, 0);
    case 1: return push(L, s.memory_used / 1024);
    case 4:  // a cycle has ended: a loop until it has ends too
    case 5: return push(L, true);
    case 6:
    case 7: return push(L, "incremental");
    case 8: return push(L, 200);
    case 9: return push(L, 100);
    default: return push(L, 0);
  }
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
    case 0: return push(L, rng.unit53());
    case 1: {
      const lua_Integer hi = luaL_checkinteger(L, 1);
      if (hi == 0) return push(L, random_between(rng, LUA_MININTEGER, LUA_MAXINTEGER));  // all bits
      if (hi < 1) fail(L, "math.random: expected a whole number of at least 1, got " + describe(L, 1));
      return push(L, random_between(rng, 1, hi));
    }
    case 2: {
      const lua_Integer lo = luaL_checkinteger(L, 1), hi = luaL_checkinteger(L, 2);
      if (lo > hi) fail(L, "math.random: expected lo at most hi, got " + describe(L, 1) + ", " + describe(L, 2));
      return push(L, random_between(rng, lo, hi));
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
  return push(L, seed, stream);
}

// The runtime's own: the same on every machine.
template <double (*F)(double)>
int math_wave(lua_State* L) {
  return push(L, F(luaL_checknumber(L, 1)));
}

void make_classes(lua_State* L) {
  const State& s = state(L);
  make_class(L, Class::force, {object_methods(), force_methods()});
  make_class(L, Class::object, {object_methods()});
  for (std::size_t i = 0; i < s.object_classes.size(); ++i)
    make_class(L, static_cast<Class>(kOwnClasses + static_cast<int>(i)),
               {object_methods(), s.object_classes[i]->methods});
  std::vector<std::span<const Method>> world = {world_methods()};
  for (const Part* part : s.options.parts) world.push_back(part->world);
  make_class(L, Class::world, world);
  open_classes(L);
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

std::string text_of_values(lua_State* L, int first) {
  std::string line;
  for (int i = first, last = lua_gettop(L); i <= last; ++i) {
    push_text(L, i);
    if (i > first) line += '\t';
    line += text_at(L, -1);
    lua_pop(L, 1);
  }
  return line;
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
  if (const std::string method = method_text(L, index); !method.empty()) {
    push(L, method);
    return;
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
  for (const char* name : {"dofile", "loadfile", "warn"}) {
    lua_pushnil(L);
    lua_setglobal(L, name);
  }
  set_functions(L, "math",
                {{"random", guard<math_random>},
                 {"randomseed", guard<math_randomseed>},
                 {"sin", math_wave<sine>},
                 {"cos", math_wave<cosine>},
                 {"tan", math_wave<tangent>}});
  set_functions(L, "_G",
                {{"print", guard<lua_print>},
                 {"tostring", guard<lua_tostring_safe>},
                 {"collectgarbage", guard<lua_collectgarbage>}});
  lua_getglobal(L, "string");
  set_field(L, "dump", nullptr);
  lua_pop(L, 1);

  push_weak_table(L, "v");
  s.worlds_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  push_weak_table(L, "k");
  s.ids_ref = luaL_ref(L, LUA_REGISTRYINDEX);
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
  open_expect(L);

  // one script cannot change the strings of another
  lua_pushstring(L, "");
  lua_getmetatable(L, -1);
  set_field(L, "__metatable", false);
  lua_settop(L, 0);
  return 0;
}

}  // namespace feder::lua
