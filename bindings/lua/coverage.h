// Which lines of scripts have run, and which could.
#pragma once
#include "lua/state.h"

namespace feder::lua {

// Of the line hook: the line has run.
void cover_line(lua_State* L, lua_Debug* at);
// Of the chunk on top of the stack, just loaded from a file: all lines with code.
void cover_chunk(lua_State* L, const std::filesystem::path& file);

}  // namespace feder::lua
