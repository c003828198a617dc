// What makers and methods of objects share, and the world's own methods.
#pragma once
#include "lua/records.h"

namespace feder::lua {

std::span<const Method> world_methods();

int push_vector(lua_State* L, const Vec3& v);  // three numbers
inline int return_self(lua_State* L) {
  lua_settop(L, 1);
  return 1;
}

// Where a body is, for what is attached to it. `body` is one.
inline Pose pose_of(lua_State* L, WorldRecord& record, ObjectId body) {
  return class_row(state(L), class_of(state(L), record, body))->pose(record, body);
}

}  // namespace feder::lua
