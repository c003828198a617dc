// Forces: the kinds of the runtime, and Lua functions evaluated before each step.
#pragma once
#include <map>
#include <vector>

#include "base/math.h"
#include "forces/force.h"
#include "lua/state.h"
#include "state/objects.h"

namespace feder::lua {

struct ScriptForce {
  ObjectId object;   // the force's handle
  int function = 0;  // key in the world's callbacks
  bool all = false;
  TagMask tags = 0;
  ObjectId target;
  std::vector<std::uint32_t> points;  // of `target`, ascending; empty: all
  std::size_t profile = 0;
  std::map<std::uint32_t, Vec3> held;  // by body index: the force when it was last awake
};

struct ScriptForces {
  std::vector<ScriptForce> list;
};

// Evaluates the functions for every point and body they act on, and hands the sums to the systems.
void apply_script_forces(lua_State* L, WorldRecord& record);

// Forces asked at every stage (force_stages.cpp): before and after World::step.
std::unique_ptr<Force> make_stage_force(WorldRecord& record, int function, std::size_t profile);
void begin_stages(lua_State* L, WorldRecord& record);
void end_stages(lua_State* L, WorldRecord& record);
// May a script call this API function ("net:point") while a stage asks it? Those that only tell the state.
bool answers_in_step(const char* function);

int world_force(lua_State* L);
std::span<const Method> force_methods();

}  // namespace feder::lua
