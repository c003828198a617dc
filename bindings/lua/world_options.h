// The options of a world, from a script and from the command line.
#pragma once
#include "lua/records.h"

namespace feder::lua {

// Reads feder.world's table (or a scene's `world`) at `index`, then the host's overrides if wanted, and checks the
// result: every named system is made once in a world that is thrown away, so that a wrong option is an error here and
// not later.
WorldSettings read_world_options(lua_State* L, int index, const std::string& owner, bool overrides = true);

}  // namespace feder::lua
