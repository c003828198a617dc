#pragma once

struct lua_State;

namespace feder::lua {

int feder_choices(lua_State* L);

}  // namespace feder::lua
