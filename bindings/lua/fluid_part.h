// Fluids, their emitters and drains in Lua.
#pragma once
#include "feder/fluid.h"
#include "lua/method.h"

namespace feder::lua {

const Part& fluid_part();

std::size_t fluid_fill(const Object<Fluid>& f, lua_State* L);
struct FluidBox {
  Vec3 lo = Vec3::Zero(), hi = Vec3::Zero();
};
FluidBox fluid_box(const Object<Fluid>& f, lua_State* L);  // options of fluid:flux
ObjectId fluid_emitter(const Object<Fluid>& f, lua_State* L);
ObjectId fluid_drain(const Object<Fluid>& f, lua_State* L);
ObjectId world_fluid(WorldRecord& r, lua_State* L);
void world_interface(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> interface_rows();
std::vector<OptionInfo> fluid_rows();
std::vector<OptionInfo> fill_rows();
std::vector<OptionInfo> flux_rows();
std::vector<OptionInfo> emitter_rows();
std::vector<OptionInfo> drain_rows();

}  // namespace feder::lua
