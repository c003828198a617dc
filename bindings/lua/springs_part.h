// Nets in Lua.
#pragma once
#include "feder/net.h"
#include "lua/method.h"

namespace feder::lua {

const Part& springs_part();

ObjectId world_net(WorldRecord& r, lua_State* L);
std::vector<OptionInfo> net_rows();
std::vector<Advice> advise_nets(World& world);
SpringDesc read_spring(Options& o, std::size_t point_count);

}  // namespace feder::lua
