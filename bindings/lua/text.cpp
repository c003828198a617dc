// string functions that could show addresses or run for long without executing instructions.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "lua/sandbox.h"

namespace feder::lua {
namespace {

// Calls the library's function in upvalue 1 with the arguments on the stack.
int call_original(lua_State* L) {
  lua_pushvalue(L, lua_upvalueindex(1));
  lua_insert(L, 1);
  lua_call(L, lua_gettop(L) - 1, LUA_MULTRET);
  return lua_gettop(L);
}

// format: %p shows an address, and %s of a table would.
int safe_format(lua_State* L) {
  std::size_t size = 0;
  const char* format = luaL_checklstring(L, 1, &size);
  const int count = lua_gettop(L);
  int argument = 1;
  for (std::size_t i = 0; i < size; ++i) {
    if (format[i] != '%') continue;
    if (++i < size && format[i] == '%') continue;
    while (i < size && std::strchr("-+ #0123456789.", format[i]) && format[i]) ++i;
    ++argument;
    if (i >= size) break;
    if (format[i] == 'p') fail(L, "string.format: '%p' is not available");
    if (format[i] != 's' || argument > count) continue;
    push_text(L, argument);
    charge(L, lua_rawlen(L, -1));
    lua_replace(L, argument);
  }
  return call_original(L);
}

int charged_rep(lua_State* L) {
  std::size_t size = 0;
  luaL_checklstring(L, 1, &size);
  const lua_Integer times = luaL_checkinteger(L, 2);
  if (times > 0 && static_cast<double>(size + 1) * static_cast<double>(times) > 1e9)
    fail(L, "string.rep: the result would be larger than 1 GB");
  if (times > 0) charge(L, (size / 8 + 1) * static_cast<std::uint64_t>(times));
  return call_original(L);
}

int charged_text(lua_State* L) {
  if (lua_type(L, 1) == LUA_TSTRING) charge(L, lua_rawlen(L, 1) / 8);
  return call_original(L);
}

// The matcher backtracks inside C, where no budget sees it: with a budget, patterns whose worst case is hopeless on
// this subject are refused. Every unbounded repetition multiplies by the length, and so does a free start.
int bounded_pattern(lua_State* L) {
  if (state(L).options.instruction_limit > 0 && lua_type(L, 1) == LUA_TSTRING && lua_type(L, 2) == LUA_TSTRING) {
    const double length = static_cast<double>(lua_rawlen(L, 1)) + 1;
    std::size_t size = 0;
    const char* pattern = lua_tolstring(L, 2, &size);
    int repeats = size > 0 && pattern[0] == '^' ? 0 : 1;
    for (std::size_t i = 0; i < size; ++i) {
      if (pattern[i] == '%') {
        ++i;
        continue;
      }
      repeats += i > 0 && (pattern[i] == '*' || pattern[i] == '+' || pattern[i] == '-');
    }
    if (repeats > 1 && repeats * std::log10(length) > 9)
      fail(L, "string: the pattern could take too long on " + std::to_string(static_cast<long long>(length) - 1) +
                  " characters");
    charge(L, static_cast<std::uint64_t>(length) / 4);
  }
  return call_original(L);
}

void wrap(lua_State* L, const char* name, lua_CFunction f) {
  lua_getfield(L, -1, name);
  lua_pushcclosure(L, f, 1);
  lua_setfield(L, -2, name);
}

}  // namespace

void open_text(lua_State* L) {
  lua_getglobal(L, "string");
  wrap(L, "format", guard<safe_format>);
  wrap(L, "rep", guard<charged_rep>);
  for (const char* name : {"upper", "lower", "reverse"}) wrap(L, name, guard<charged_text>);
  for (const char* name : {"find", "match", "gmatch", "gsub"}) wrap(L, name, guard<bounded_pattern>);
  lua_pop(L, 1);
}

}  // namespace feder::lua
