// feder.sdf and what is made of fields: union, difference, intersection, offset.
#pragma once
#include "lua/options.h"

namespace feder::lua {

std::span<const Method> sdf_functions();  // of the module feder; none in a build without fields
std::vector<OptionInfo> sdf_rows();
int feder_sdf(lua_State* L);

}  // namespace feder::lua
