// Buffers: userdata with numbers behind a count.
#include "lua/buffer.h"

#include <algorithm>

#include "lua/method.h"

namespace feder::lua {
namespace {

constexpr std::int64_t kMaxNumbers = std::int64_t(1) << 27;

struct BufferBlock {
  std::size_t count;
  double* numbers() { return reinterpret_cast<double*>(this + 1); }
};

// The address of buf[i].
double* element(lua_State* L, BufferBlock& b) {
  int whole = 0;
  const lua_Integer i = lua_type(L, 2) == LUA_TNUMBER ? lua_tointegerx(L, 2, &whole) : 0;
  if (whole && i >= 1 && static_cast<std::uint64_t>(i) <= b.count) return b.numbers() + (i - 1);
  fail(L, "buffer: expected an index from 1 to " + std::to_string(b.count) + ", got " + describe(L, 2));
}

std::span<double> push_buffer(lua_State* L, std::size_t count) {
  auto* b = static_cast<BufferBlock*>(lua_newuserdatauv(L, sizeof(BufferBlock) + count * sizeof(double), 0));
  b->count = count;
  std::fill_n(b->numbers(), count, 0.0);
  push_class(L, Class::buffer);
  lua_setmetatable(L, -2);
  return {b->numbers(), count};
}

int buffer_index(lua_State* L) {  // upvalue 1: methods
  auto* b = static_cast<BufferBlock*>(lua_touserdata(L, 1));
  if (lua_type(L, 2) == LUA_TSTRING) {
    lua_pushvalue(L, 2);
    lua_gettable(L, lua_upvalueindex(1));
    return 1;
  }
  return push(L, *element(L, *b));
}

int buffer_newindex(lua_State* L) {
  double* at = element(L, *static_cast<BufferBlock*>(lua_touserdata(L, 1)));
  if (lua_type(L, 3) != LUA_TNUMBER) fail(L, "buffer: expected a number, got " + describe(L, 3));
  *at = lua_tonumber(L, 3);
  return 0;
}

int buffer_len(lua_State* L) { return push(L, static_cast<BufferBlock*>(lua_touserdata(L, 1))->count); }

std::string buffer_tostring(lua_State* L) {
  return "buffer of " + std::to_string(static_cast<BufferBlock*>(lua_touserdata(L, 1))->count) + " numbers";
}

int buffer_fill(lua_State* L) {
  const std::span<double> numbers = test_buffer(L, 1);
  if (!numbers.data()) wrong_self(L, "buffer");
  std::ranges::fill(numbers, check_number(L, 2, function_name(L)));
  lua_settop(L, 1);
  return 1;
}

const Method kBufferMethods[] = {
    {"fill", guard<buffer_fill>, "buf:fill(x) -> self", "sets every number to x"},
};

}  // namespace

std::span<const Method> buffer_methods() { return kBufferMethods; }

std::span<double> test_buffer(lua_State* L, int index) {
  auto* b = static_cast<BufferBlock*>(test_class(L, index, Class::buffer));
  if (!b) return {};
  return {b->numbers(), b->count};
}

int feder_buffer(lua_State* L) {
  const std::int64_t count = check_integer(L, 1, function_name(L), 1, kMaxNumbers);
  charge(L, static_cast<std::uint64_t>(count) / 16);
  push_buffer(L, static_cast<std::size_t>(count));
  return 1;
}

void open_buffer(lua_State* L) {
  set_metamethods(
      L, Class::buffer,
      {{"__newindex", guard<buffer_newindex>}, {"__len", buffer_len}, {"__tostring", method<buffer_tostring>}});
  push_class(L, Class::buffer);
  lua_getfield(L, -1, "__index");
  lua_pushcclosure(L, guard<buffer_index>, 1);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 1);
}

std::span<double> push_output(lua_State* L, std::size_t count) {
  if (lua_isnoneornil(L, 2)) return push_buffer(L, count);
  const std::span<double> out = test_buffer(L, 2);
  if (out.size() < count)
    fail_here(L, "expected a buffer of at least " + std::to_string(count) + " numbers, got " +
                     (out.data() ? "one of " + std::to_string(out.size()) : describe(L, 2)));
  lua_settop(L, 2);
  return out;
}

int push_vectors(lua_State* L, const std::vector<Vec3>& points) {
  const std::span<double> out = push_output(L, points.size() * 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int k = 0; k < 3; ++k) out[i * 3 + static_cast<std::size_t>(k)] = points[i][k];
  return 1;
}

}  // namespace feder::lua
