// The globals of scripts: an allow-list, made once per state.
#pragma once
#include "lua/state.h"

namespace feder::lua {

// Opens base, table, string, math, utf8 and coroutine without what could leave the sandbox, makes the classes and the
// module "feder". A lua_CFunction.
int open_sandbox(lua_State* L);

// Text of a value without addresses: tables and functions get numbers in the order they are first shown.
void push_text(lua_State* L, int index);
// What print shows of the values at `first` to the top, with tabs between.
std::string text_of_values(lua_State* L, int first);
lua_Integer value_id(lua_State* L, int index);

void set_functions(lua_State* L, const char* table, std::initializer_list<luaL_Reg> rows);
// Puts f in the place of functions of a library's table, which become its upvalue 1; upvalue 2 is their name if
// `named`.
void wrap(lua_State* L, const char* table, std::initializer_list<const char*> names, lua_CFunction f,
          bool named = false);

// Replacements with a promised order: pairs, next, table.sort (ordered.cpp).
void open_ordered(lua_State* L);
// string functions with a budget (text.cpp).
void open_text(lua_State* L);
// pcall, xpcall, coroutines, load, setmetatable ... (protected.cpp).
void open_protected(lua_State* L);
// The module table of require "feder" (module.cpp).
void open_module(lua_State* L);
void push_module(lua_State* L);  // that table
// The metatable on top makes unknown names of a table of functions errors, with the nearest one.
void refuse_unknown(lua_State* L, const char* name);

}  // namespace feder::lua
