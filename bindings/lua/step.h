// One step of a world as scripts see it.
#pragma once
#include "lua/records.h"

namespace feder::lua {

// Script forces, the step, then timers, events, tasks and the scene's update(). The host's callback is the caller's.
void run_step(lua_State* L, WorldRecord& record);
// A snapshot as scripts hold it: the image with its owner key, so that an edited one is refused.
std::string write_snapshot(WorldRecord& record);
void restore_snapshot(lua_State* L, WorldRecord& record, std::string_view text);

}  // namespace feder::lua
