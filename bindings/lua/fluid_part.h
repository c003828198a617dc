// Fluids, their emitters and drains in Lua.
#pragma once
#include "feder/fluid.h"
#include "lua/objects.h"

namespace feder::lua {

const Part& fluid_part();

Fluid& fluids(WorldRecord& record);  // made on first use
int fluid_fill(lua_State* L);
int fluid_emitter(lua_State* L);
int fluid_drain(lua_State* L);
int world_fluid(lua_State* L);
std::vector<OptionInfo> fluid_rows();
std::vector<OptionInfo> fill_rows();
std::vector<OptionInfo> emitter_rows();
std::vector<OptionInfo> drain_rows();
std::span<const Method> fluid_methods();
std::span<const Method> emitter_methods();
std::span<const Method> drain_methods();

}  // namespace feder::lua
