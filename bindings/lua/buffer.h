// feder.buffer: n numbers in one block, for bulk data. buf[i] counts from 1, #buf is n.
#pragma once
#include <span>
#include <vector>

#include "feder/types.h"
#include "lua/state.h"

namespace feder::lua {

// The numbers of the buffer at `index`; empty `data()` when it is none.
std::span<double> test_buffer(lua_State* L, int index);
// Pushes the buffer at index 2, which must have room for `count` numbers, or a new one when there is none.
std::span<double> push_output(lua_State* L, std::size_t count);
// Three numbers per point into the buffer at index 2, or into a new one. Returns 1: the buffer is on top.
int push_vectors(lua_State* L, const std::vector<Vec3>& points);
int feder_buffer(lua_State* L);
std::span<const Method> buffer_methods();
void open_buffer(lua_State* L);

}  // namespace feder::lua
