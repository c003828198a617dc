// What the files about fluids share.
#pragma once
#include "lua/records.h"

namespace feder {
class Fluid;
}

namespace feder::lua {

Fluid& fluids(WorldRecord& record);  // made on first use
int fluid_fill(lua_State* L);
int fluid_emitter(lua_State* L);
int fluid_drain(lua_State* L);

}  // namespace feder::lua
