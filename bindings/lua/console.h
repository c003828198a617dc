// Lua text that somebody types while a scene runs.
#pragma once
#include "lua/state.h"

namespace feder::lua {

// Runs the text between two steps; raises Lua errors. Returns what an expression gave, as print would show it.
std::string run_console(lua_State* L, std::string_view text, const std::string& chunk_name);

}  // namespace feder::lua
