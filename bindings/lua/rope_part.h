// Ropes in Lua.
#pragma once
#include "feder/rope.h"
#include "lua/method.h"

namespace feder::lua {

const Part& rope_part();

ObjectId world_rope(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> rope_rows();

}  // namespace feder::lua
