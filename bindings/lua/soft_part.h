// Soft bodies in Lua.
#pragma once
#include "feder/soft.h"
#include "lua/method.h"

namespace feder::lua {

const Part& soft_part();

ObjectId world_soft(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> soft_rows();

}  // namespace feder::lua
