// What parts use to make the objects of a scene in YAML. The options of an object are the table on top of the stack.
#pragma once
#include "lua/state.h"

namespace feder::lua {

// Calls object:<maker>(options), both by their indices; the results are pushed.
void call_maker(lua_State* L, int object, const char* maker, int options, int results);
// Calls world:<maker>(options); pops them.
void make_object(lua_State* L, int world, const char* maker);
// The shape of the table on top: { box: [1, 1, 1] } or { type: box, size: [..] | radius:, height: ... }. Replaces it.
void make_shape(lua_State* L);
// The same for table.shape, when there is one.
void make_shape_field(lua_State* L, int table);
// Replaces the name at options[key] by the object.
void resolve_name(lua_State* L, int world, int options, const char* key);
// Takes the locations of one table over to another, so that copies of YAML tables keep theirs.
void copy_locations(lua_State* L, int from, int to);
// Of a parameter that has options.
std::vector<OptionInfo> yaml_param_rows();

}  // namespace feder::lua
