// The console: text runs in an environment of its own, which falls back on the globals of the script.
#include "lua/console.h"

#include "lua/records.h"
#include "lua/sandbox.h"

namespace feder::lua {
namespace {

// Leaves the console's environment: names of its own, then world, scene and feder, then the script's globals.
void push_environment(lua_State* L) {
  State& s = state(L);
  if (s.console_ref == LUA_NOREF) {
    lua_newtable(L);
    lua_newtable(L);
    lua_pushglobaltable(L);
    lua_setfield(L, -2, "__index");
    lua_setmetatable(L, -2);
    s.console_ref = luaL_ref(L, LUA_REGISTRYINDEX);
  }
  lua_rawgeti(L, LUA_REGISTRYINDEX, s.console_ref);
  if (const WorldRecord* r = s.current(); r && r->world)
    push_world(L, *r);
  else
    lua_pushnil(L);
  lua_setfield(L, -2, "world");
  if (s.scene.passed != LUA_NOREF) {
    lua_rawgeti(L, LUA_REGISTRYINDEX, s.scene.passed);
    lua_setfield(L, -2, "scene");
  }
  push_module(L);
  lua_setfield(L, -2, "feder");
}

// Pushes the text as a function: as an expression when it is one.
void compile(lua_State* L, std::string_view text, const std::string& chunk) {
  const std::string expression = "return " + std::string(text);
  if (luaL_loadbufferx(L, expression.data(), expression.size(), chunk.c_str(), "t") == LUA_OK) return;
  lua_pop(L, 1);
  if (luaL_loadbufferx(L, text.data(), text.size(), chunk.c_str(), "t") != LUA_OK) lua_error(L);
}

}  // namespace

std::string run_console(lua_State* L, std::string_view text, const std::string& chunk_name) {
  const int base = lua_gettop(L);
  compile(L, text, "=" + chunk_name);
  push_environment(L);
  if (!lua_setupvalue(L, -2, 1)) lua_pop(L, 1);
  lua_call(L, 0, LUA_MULTRET);
  const std::string result = text_of_values(L, base + 1);
  lua_settop(L, base);
  return result;
}

}  // namespace feder::lua
