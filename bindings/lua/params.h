// feder.param: values that the command line, a viewer or a study may set.
#pragma once
#include "lua/state.h"

namespace feder::lua {

int feder_param(lua_State* L);
std::vector<OptionInfo> param_rows();
// After loading: a --set name that no feder.param declared is an error.
void check_set_names(const State& s);

}  // namespace feder::lua
