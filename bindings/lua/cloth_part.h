// Cloth in Lua.
#pragma once
#include "feder/cloth.h"
#include "lua/method.h"

namespace feder::lua {

const Part& cloth_part();

int world_cloth(lua_State* L);
std::vector<OptionInfo> cloth_rows();
std::span<const Method> cloth_methods();

}  // namespace feder::lua
