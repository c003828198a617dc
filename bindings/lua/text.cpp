// Library functions that could show addresses or work for long without executing instructions: what they are given is
// charged to the budget, then the library's function runs in this one's place, so that its errors name function,
// argument and caller as in stock Lua. What they return is charged by the allocator.
#include <cstring>

#include "lua/pattern.h"
#include "lua/sandbox.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

constexpr std::uint64_t kTextPerUnit = 8;

int call_original(lua_State* L) { return lua_tocfunction(L, lua_upvalueindex(1))(L); }

// format: %p shows an address, and %s of a table would.
int safe_format(lua_State* L) {
  std::size_t size = 0;
  const char* format = luaL_checklstring(L, 1, &size);
  charge(L, size / kTextPerUnit);
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
    lua_replace(L, argument);
  }
  return call_original(L);
}

int charged_rep(lua_State* L) {
  std::size_t size = 0, separator = 0;
  luaL_checklstring(L, 1, &size);
  const lua_Integer times = luaL_checkinteger(L, 2);
  luaL_optlstring(L, 3, "", &separator);
  const double bytes = static_cast<double>(size + separator + 1) * static_cast<double>(times);
  if (bytes > 1e9) fail(L, "string.rep: the result would be larger than 1 GB");
  if (bytes > 0) charge(L, static_cast<std::uint64_t>(times));
  return call_original(L);
}

// Work by the length of the first kTexts arguments: one of upper, lower, reverse, pack formats, utf8 and numbers in
// long strings; unpack walks over its format and, for zero-terminated strings, over its data.
template <int kTexts>
int charged_text(lua_State* L) {
  for (int i = 1; i <= kTexts; ++i)
    if (lua_type(L, i) == LUA_TSTRING) charge(L, lua_rawlen(L, i) / kTextPerUnit);
  return call_original(L);
}

}  // namespace

void set_functions(lua_State* L, const char* table, std::initializer_list<luaL_Reg> rows) {
  lua_getglobal(L, table);
  for (const luaL_Reg& row : rows) set_field(L, row.name, row.func);
  lua_pop(L, 1);
}

void wrap(lua_State* L, const char* table, std::initializer_list<const char*> names, lua_CFunction f, bool named) {
  lua_getglobal(L, table);
  for (const char* name : names) {
    lua_getfield(L, -1, name);
    if (named) lua_pushstring(L, name);
    lua_pushcclosure(L, f, named ? 2 : 1);
    lua_setfield(L, -2, name);
  }
  lua_pop(L, 1);
}

void open_text(lua_State* L) {
  wrap(L, "string", {"format"}, guard<safe_format>);
  wrap(L, "string", {"rep"}, guard<charged_rep>);
  wrap(L, "string", {"upper", "lower", "reverse", "byte", "pack", "packsize"}, guard<charged_text<1>>);
  wrap(L, "string", {"unpack"}, guard<charged_text<2>>);
  wrap(L, "utf8", {"len", "offset", "codepoint"}, guard<charged_text<1>>);
  wrap(L, "_G", {"tonumber"}, guard<charged_text<1>>);
  set_functions(L, "string",
                {{"find", guard<pattern_find>},
                 {"match", guard<pattern_match>},
                 {"gmatch", guard<pattern_gmatch>},
                 {"gsub", guard<pattern_gsub>}});
}

}  // namespace feder::lua
