// Where objects are, asked by their Lua methods: every kind that has `position` or `positions` answers.
#pragma once
#include <initializer_list>
#include <vector>

#include "lua/records.h"

namespace feder::lua {

using Points = std::vector<double>;  // three numbers each

// Of the object at `index`.
bool has_method(lua_State* L, int index, const char* name);
// Calls it with numbers; returns how many results are on top.
int call_method_of(lua_State* L, int index, const char* name, std::initializer_list<double> numbers = {});
// The points of a soft thing, or the origin of a body; in a `frame`, which turns, also its three unit points.
Points points_of(lua_State* L, int index, bool frame = false);

// Of all objects that are somewhere.
std::vector<ObjectSample> sample_objects(lua_State* L, WorldRecord& record);

}  // namespace feder::lua
