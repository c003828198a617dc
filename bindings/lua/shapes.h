// Shapes as Lua values: immutable, shared between bodies.
#pragma once
#include "feder/shape.h"
#include "lua/options.h"

namespace feder::lua {

bool shape_option(Options& o, const char* key, ShapePtr& out);
// A list of {x, y, z} tables, or a buffer of 3 n numbers.
std::vector<Vec3> check_points(lua_State* L, int index, const std::string& what, bool planar = false);
// The same under a key.
bool points_option(Options& o, const char* key, std::vector<Vec3>& out);
std::span<const Method> shape_functions();  // of the module feder
std::span<const Method> shape_methods();
void open_shapes(lua_State* L);

}  // namespace feder::lua
