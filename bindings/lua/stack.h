// Values on the Lua stack by their C++ type, tables by their entries, userdata by their class.
#pragma once
#include <array>
#include <concepts>
#include <string_view>
#include <utility>

#include "feder/types.h"
#include "lua/state.h"

namespace feder::lua {

// Each pushes a value and returns how many Lua values that are.
template <class T>
int push(lua_State* L, const T& x) {
  if constexpr (std::same_as<T, bool>)
    lua_pushboolean(L, x);
  else if constexpr (std::integral<T>)
    lua_pushinteger(L, static_cast<lua_Integer>(x));
  else if constexpr (std::floating_point<T>)
    lua_pushnumber(L, x);
  else if constexpr (std::same_as<T, std::nullptr_t>)
    lua_pushnil(L);
  else if constexpr (std::convertible_to<const T&, std::string_view>)
    lua_pushlstring(L, std::string_view(x).data(), std::string_view(x).size());
  else
    lua_pushcfunction(L, x);
  return 1;
}
inline int push(lua_State* L, const Vec3& v) {
  for (int k = 0; k < 3; ++k) lua_pushnumber(L, v[k]);
  return 3;
}
template <class T, std::size_t N>
int push(lua_State* L, const std::array<T, N>& values) {
  for (const T& x : values) push(L, x);
  return N;
}
template <class First, class Second, class... More>
int push(lua_State* L, const First& first, const Second& second, const More&... more) {
  int count = push(L, first);
  count += push(L, second);
  ((count += push(L, more)), ...);
  return count;
}

// The value as a field of the table on top.
template <class T>
void set_field(lua_State* L, const char* key, const T& value) {
  push(L, value);
  lua_setfield(L, -2, key);
}
// {x, y, z, nx, ny, nz} of the table on top.
inline void set_point_and_normal(lua_State* L, const Vec3& point, const Vec3& normal) {
  static constexpr const char* kNames[] = {"x", "y", "z", "nx", "ny", "nz"};
  for (int k = 0; k < 6; ++k) set_field(L, kNames[k], k < 3 ? point[k] : normal[k - 3]);
}

// A list of what push_one(x) pushes of each.
template <class Values, class F>
void push_list(lua_State* L, const Values& all, F&& push_one) {
  lua_newtable(L);
  lua_Integer n = 0;
  for (const auto& x : all) {
    push_one(x);
    lua_rawseti(L, -2, ++n);
  }
}

// Calls f(k) for the entries 1, 2 ... of the list at `index`, each on top of the stack meanwhile.
template <class F>
void each_entry(lua_State* L, int index, F&& f) {
  index = lua_absindex(L, index);
  const auto count = static_cast<lua_Integer>(lua_rawlen(L, index));
  for (lua_Integer k = 1; k <= count; ++k) {
    lua_rawgeti(L, index, k);
    f(k);
    lua_pop(L, 1);
  }
}

// Sets the fields of the table at `from` in the table on top.
inline void copy_fields(lua_State* L, int from) {
  from = lua_absindex(L, from);
  for (lua_pushnil(L); lua_next(L, from);) {
    lua_pushvalue(L, -2);
    lua_insert(L, -2);
    lua_rawset(L, -4);
  }
}

// The string at `index` with its zero bytes; empty when it is none.
inline std::string_view text_at(lua_State* L, int index) {
  std::size_t size = 0;
  const char* const text = lua_tolstring(L, index, &size);
  return {text ? text : "", size};
}

// `mode`: "k" keys, "v" values.
inline void push_weak_table(lua_State* L, const char* mode) {
  lua_newtable(L);
  lua_newtable(L);
  set_field(L, "__mode", mode);
  lua_setmetatable(L, -2);
}

// The value on top takes the place of another in the registry.
inline void replace_reference(lua_State* L, int& reference) {
  luaL_unref(L, LUA_REGISTRYINDEX, reference);
  lua_pushvalue(L, -1);
  reference = luaL_ref(L, LUA_REGISTRYINDEX);
}

// Pushes a userdata of the class.
template <class T>
T& push_userdata(lua_State* L, Class c, T value, int user_values = 0) {
  auto* block = new (lua_newuserdatauv(L, sizeof(T), user_values)) T(std::move(value));
  push_class(L, c);
  lua_setmetatable(L, -2);
  return *block;
}

inline void set_metamethods(lua_State* L, Class c, std::initializer_list<luaL_Reg> rows) {
  push_class(L, c);
  for (const luaL_Reg& row : rows) set_field(L, row.name, row.func);
  lua_pop(L, 1);
}

}  // namespace feder::lua
