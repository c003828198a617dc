// Shapes as Lua values: immutable, shared between bodies.
#pragma once
#include "geom/shape.h"
#include "lua/options.h"

namespace feder::lua {

void push_shape(lua_State* L, ShapePtr shape);
// The shape at `index`; an error naming `what` when it is none.
ShapePtr check_shape(lua_State* L, int index, const std::string& what);
bool shape_option(Options& o, const char* key, ShapePtr& out);
// A list of {x, y, z} tables, or a buffer of 3 n numbers.
std::vector<Vec3> check_points(lua_State* L, int index, const std::string& what, bool planar = false);
std::span<const Method> shape_functions();  // of the module feder
std::span<const Method> shape_methods();
void open_shapes(lua_State* L);

// box = {min, max}, or shape = with position; and rotation. A mistake when there is neither or both.
void box_or_shape(Options& o, ShapePtr& shape, Vec3& position, Quat& rotation);
bool has_volume(Options& o);  // is one of these given?
template <class T>
constexpr Option<T> box_row(void (*read)(Options&, const OptionRow&, T&)) {
  return special("box", "{min, max}", read, "m");
}

}  // namespace feder::lua
