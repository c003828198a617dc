// What runs other functions or code: pcall, xpcall, coroutine, load, setmetatable. A limit that was reached passes
// through all of them; text becomes code only as source.
#include "lua/library.h"
#include "lua/sandbox.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

constexpr std::uint64_t kErrorCost = 500;  // instructions: unwinding to a pcall takes as long

int finish_pcall(lua_State* L, int status, lua_KContext) {
  State& s = state(L);
  s.check_limits(L, status);
  if (status == LUA_OK || status == LUA_YIELD) return lua_gettop(L);
  s.spend(L, kErrorCost);
  lua_pushboolean(L, 0);
  lua_insert(L, -2);
  return 2;
}

int safe_pcall(lua_State* L) {
  luaL_checkany(L, 1);
  lua_pushboolean(L, 1);
  lua_insert(L, 1);
  return finish_pcall(L, lua_pcallk(L, lua_gettop(L) - 2, LUA_MULTRET, 0, 0, finish_pcall), 0);
}

int finish_handler(lua_State* L, int status, lua_KContext) {  // stack: handler, its results | handler, error
  State& s = state(L);
  s.check_limits(L, status);
  if (status != LUA_OK && status != LUA_YIELD) s.spend(L, kErrorCost);
  lua_pushboolean(L, 0);
  lua_replace(L, 1);
  return lua_gettop(L);
}

// The handler runs after the stack has been unwound: in the place of the error it would run outside every limit. An
// error in it is the result, as in stock Lua.
int finish_xpcall(lua_State* L, int status, lua_KContext) {  // stack: handler, true, results | handler, ..., error
  State& s = state(L);
  s.check_limits(L, status);
  if (status == LUA_OK || status == LUA_YIELD) return lua_gettop(L) - 1;
  s.spend(L, kErrorCost);
  lua_replace(L, 2);
  lua_settop(L, 2);
  lua_pushvalue(L, 1);
  lua_insert(L, 2);  // handler, handler, error
  return finish_handler(L, lua_pcallk(L, 1, LUA_MULTRET, 0, 0, finish_handler), 0);
}

int safe_xpcall(lua_State* L) {
  luaL_checktype(L, 2, LUA_TFUNCTION);
  // f, handler, arguments -> handler, true, f, arguments
  lua_pushvalue(L, 1);
  lua_pushvalue(L, 2);
  lua_replace(L, 1);
  lua_pushboolean(L, 1);
  lua_replace(L, 2);
  lua_insert(L, 3);
  return finish_xpcall(L, lua_pcallk(L, lua_gettop(L) - 3, LUA_MULTRET, 0, 0, finish_xpcall), 0);
}

int safe_setmetatable(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  luaL_argexpected(L, lua_isnil(L, 2) || lua_istable(L, 2), 2, "nil or table");
  if (luaL_getmetafield(L, 1, "__metatable") != LUA_TNIL) luaL_error(L, "cannot change a protected metatable");
  if (lua_istable(L, 2)) {
    lua_pushstring(L, "__gc");
    if (lua_rawget(L, 2) != LUA_TNIL) fail(L, "setmetatable: __gc is not available to scripts");
  }
  lua_settop(L, 2);
  lua_setmetatable(L, 1);
  return 1;
}

// The text that the reader function at 1 gives, piece by piece. False: its error is on the stack.
bool read_pieces(lua_State* L, std::string& text) {
  State& s = state(L);
  for (;;) {
    lua_pushvalue(L, 1);
    const int status = lua_pcall(L, 0, 1, 0);
    s.check_limits(L, status);
    if (status != LUA_OK) return false;
    if (lua_isnil(L, -1)) break;
    if (!lua_isstring(L, -1)) {
      luaL_where(L, 1);
      lua_pushstring(L, "reader function must return a string");
      lua_concat(L, 2);
      return false;
    }
    const std::string_view piece = text_at(L, -1);
    if (piece.empty()) break;
    text += piece;
    lua_pop(L, 1);
    charge(L, piece.size());
    if (text.size() > (std::size_t(64) << 20)) fail(L, "load: more than 64 MB of text");
  }
  lua_pop(L, 1);
  return true;
}

int load_failed(lua_State* L) {  // the error is on top
  luaL_pushfail(L);
  lua_insert(L, -2);
  return 2;
}

// load(text | function, [name], [mode], [environment]): source text only.
int safe_load(lua_State* L) {
  lua_settop(L, lua_gettop(L) > 4 ? 4 : lua_gettop(L));
  const bool has_environment = lua_gettop(L) == 4;
  const std::string mode = luaL_optstring(L, 3, "bt");
  const bool given = lua_isstring(L, 1);
  std::string text;
  if (given) {
    text = text_at(L, 1);
    charge(L, text.size());
  } else {
    luaL_checktype(L, 1, LUA_TFUNCTION);
  }
  const std::string name = luaL_optstring(L, 2, given ? lua_tostring(L, 1) : "=(load)");
  if (!given && !read_pieces(L, text)) return load_failed(L);
  if (mode.find('t') == std::string::npos && !text.starts_with("\27")) {
    lua_pushfstring(L, "attempt to load a text chunk (mode is '%s')", mode.c_str());
    return load_failed(L);
  }
  if (luaL_loadbufferx(L, text.data(), text.size(), name.c_str(), "t") != LUA_OK) return load_failed(L);
  if (has_environment) {
    lua_pushvalue(L, 4);
    if (!lua_setupvalue(L, -2, 1)) lua_pop(L, 1);
  }
  return 1;
}

// coroutine.resume, close: (true, ...) or (false, error); a limit that was reached goes on. The library's function runs
// in this one's place, so that nesting costs no level of the C stack and errors name the caller.
int safe_resume(lua_State* L) {  // upvalue 1: the library's function
  lua_State* thread = lua_tothread(L, 1);
  const lua_CFunction original = lua_tocfunction(L, lua_upvalueindex(1));
  const int results = original(L);
  State& s = state(L);
  const bool no_memory = thread && lua_status(thread) == LUA_ERRMEM;
  if (no_memory && s.limit == Limit::none) s.memory_location = location(thread);
  s.check_limits(L, no_memory ? LUA_ERRMEM : LUA_OK);
  return results;
}

}  // namespace

void open_protected(lua_State* L) {
  lua_register(L, "pcall", safe_pcall);
  lua_register(L, "xpcall", safe_xpcall);
  lua_register(L, "setmetatable", guard<safe_setmetatable>);
  lua_register(L, "load", guard<safe_load>);
  lua_register(L, "require", guard<lua_require>);
  wrap(L, "coroutine", {"resume", "close"}, safe_resume);
}

}  // namespace feder::lua
