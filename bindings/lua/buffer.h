// feder.buffer: n numbers in one block, for bulk data. buf[i] counts from 1, #buf is n.
#pragma once
#include <span>

#include "lua/state.h"

namespace feder::lua {

// The numbers of the buffer at `index`; empty `data()` when it is none.
std::span<double> test_buffer(lua_State* L, int index);
std::span<double> push_buffer(lua_State* L, std::size_t count);
int feder_buffer(lua_State* L);
std::span<const Method> buffer_methods();
void open_buffer(lua_State* L);

}  // namespace feder::lua
