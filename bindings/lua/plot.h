// feder.plot: values that a viewer draws over time.
#pragma once
#include "lua/state.h"

namespace feder::lua {

int feder_plot(lua_State* L);

}  // namespace feder::lua
