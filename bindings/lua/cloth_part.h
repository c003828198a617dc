// Cloth in Lua.
#pragma once
#include "feder/cloth.h"
#include "lua/method.h"

namespace feder::lua {

const Part& cloth_part();

ObjectId world_cloth(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> cloth_rows();

}  // namespace feder::lua
