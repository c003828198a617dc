// What makers and methods of objects share, and the world's own methods.
#pragma once
#include "lua/options.h"
#include "lua/records.h"

namespace feder::lua {

std::span<const Method> world_methods();

// The argument, a number from 1 to `count`, as an index from 0; an error says what there is so many of ("point").
std::size_t number_in(lua_State* L, int index, std::size_t count, const char* what);
inline int return_self(lua_State* L) {
  lua_settop(L, 1);
  return 1;
}

// What makers read besides the description of what they make.
template <class Desc>
struct Making : Desc {
  WorldRecord* record = nullptr;
  bool painted = false;     // by a colour of its own, or its material's
  std::uint32_t color = 0;  // 0xrrggbb
};

template <class T>
void read_color(Options& o, const OptionRow&, T& made) {
  if (o.color("color", made.color)) made.painted = true;
}

// Where a body is, for what is attached to it. `body` is one.
inline Pose pose_of(lua_State* L, WorldRecord& record, ObjectId body) {
  return class_row(state(L), class_of(state(L), record, body))->pose(record, body);
}

}  // namespace feder::lua
