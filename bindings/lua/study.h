// study = {...} of a scene: what a study asks of it.
#pragma once
#include <span>

#include "lua/options.h"

namespace feder::lua {

// Reads the key `study` of a scene's table.
StudyDeclaration read_study(Options& scene);
// These call the scene's functions, or read the values in their place; they raise Lua errors, also when the scene has
// no world yet. `t`: the time that references are asked for, s.
double scene_error(lua_State* L, std::span<const double> refined);
StudyState read_study_state(lua_State* L, const char* name, double t);
std::vector<double> read_study_numbers(lua_State* L, const char* name, double t);

std::vector<OptionInfo> study_rows();

}  // namespace feder::lua
