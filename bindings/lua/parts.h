// The parts of Lua by module, each in its library feder_lua_<module>: HostOptions{.parts = {&springs_part()}, ...}.
#pragma once
#include "lua/host.h"

namespace feder::lua {

const Part& rigid_part();
const Part& springs_part();
const Part& cloth_part();
const Part& fluid_part();

}  // namespace feder::lua
