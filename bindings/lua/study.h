// study = {...} of a scene: what a study asks of it.
#pragma once
#include "lua/options.h"

namespace feder::lua {

// Reads the key `study` of a scene's table.
StudyDeclaration read_study(Options& scene);
// Calls error(world, scene, reference); raises Lua errors, also when the scene has no world yet.
double scene_error(lua_State* L);
// Pushes the reference (nil when there is none) and appends its numbers.
void push_scene_reference(lua_State* L, std::vector<double>& numbers);

std::vector<OptionInfo> study_rows();

}  // namespace feder::lua
