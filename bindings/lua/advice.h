// What systems say about their objects before a world runs: feder.advise, `feder explain`.
#pragma once
#include "lua/state.h"

namespace feder::lua {

struct Part;

std::vector<Advice> advise(std::span<const Part* const> parts, World& world);
int feder_advise(lua_State* L);

}  // namespace feder::lua
