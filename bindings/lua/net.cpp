// The methods of nets. Points and springs count from 1.
#include <algorithm>

#include "lua/soft.h"
#include "lua/springs_part.h"

namespace feder::lua {

template <>
struct SoftPoints<Springs> {
  static constexpr const char* kOne = "point";
  static std::size_t count(const Springs& springs, ObjectId id) { return springs.point_count(id); }
};

namespace {

using Net = Soft<Springs>;

std::size_t spring_argument(lua_State* L, const Net& n) {
  return number_in(L, 2, n.system.spring_count(n.self.id), "spring");
}

int net_count(lua_State* L) {
  const Net n(L);
  lua_pushinteger(L, static_cast<lua_Integer>(n.system.point_count(n.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(n.system.spring_count(n.self.id)));
  return 2;
}

// add_spring(i, j, { stiffness = ... }) or add_spring{ i, j, stiffness = ... }.
int net_add_spring(lua_State* L) {
  const Net n(L);
  const std::size_t count = n.system.point_count(n.self.id);
  if (lua_type(L, 2) != LUA_TTABLE) {
    const std::size_t i = n.point(L, 2), j = n.point(L, 3);
    lua_newtable(L);
    if (lua_type(L, 4) == LUA_TTABLE)
      for (lua_pushnil(L); lua_next(L, 4);) lua_pushvalue(L, -2), lua_insert(L, -2), lua_rawset(L, -4);
    lua_pushinteger(L, static_cast<lua_Integer>(i) + 1), lua_rawseti(L, -2, 1);
    lua_pushinteger(L, static_cast<lua_Integer>(j) + 1), lua_rawseti(L, -2, 2);
    lua_replace(L, 2);
    lua_settop(L, 2);
  }
  Options o(L, 2, function_name(L));
  const SpringDesc s = read_spring(o, count);
  if (s.rest_length < 0 && !(length(n.system.point(n.self.id, s.i) - n.system.point(n.self.id, s.j)) > 0))
    fail_here(L, "the points are at the same place; expected a rest_length, got nil");
  lua_pushinteger(L, static_cast<lua_Integer>(n.system.add_spring(n.self.id, s)) + 1);
  return 1;
}

int net_remove_spring(lua_State* L) {
  const Net n(L);
  n.system.remove_spring(n.self.id, spring_argument(L, n));
  return return_self(L);
}

int net_strain(lua_State* L) {
  const Net n(L);
  if (!lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, n.system.strain(n.self.id, spring_argument(L, n)));
    return 1;
  }
  Real largest = 0;
  for (std::size_t k = 0; k < n.system.spring_count(n.self.id); ++k)
    largest = std::max(largest, n.system.strain(n.self.id, k));
  lua_pushnumber(L, largest);
  return 1;
}

int net_spring(lua_State* L) {
  const Net n(L);
  const SpringDesc s = n.system.spring(n.self.id, spring_argument(L, n));
  lua_pushinteger(L, static_cast<lua_Integer>(s.i) + 1);
  lua_pushinteger(L, static_cast<lua_Integer>(s.j) + 1);
  lua_pushnumber(L, s.stiffness), lua_pushnumber(L, s.damping), lua_pushnumber(L, s.rest_length);
  return 5;
}

int net_spring_limits(lua_State* L) {
  const Net n(L);
  const SpringDesc s = n.system.spring(n.self.id, spring_argument(L, n));
  lua_pushnumber(L, s.break_strain), lua_pushboolean(L, s.tension_only), lua_pushinteger(L, s.power);
  return 3;
}

const Method kNetMethods[] = {
    {"count", guard<net_count>, "net:count() -> points, springs",
     "how many it has; removed springs keep their numbers"},
    {"point", guard<soft_read<Springs, &Springs::point>>, "net:point(i) -> x, y, z", "m"},
    {"set_point", guard<soft_write<Springs, &Springs::set_point>>, "net:set_point(i, x, y, z) -> self",
     "puts a point there at once"},
    {"velocity", guard<soft_read<Springs, &Springs::velocity>>, "net:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", guard<soft_write<Springs, &Springs::set_velocity>>, "net:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", guard<soft_write<Springs, &Springs::apply_impulse>>, "net:apply_impulse(i, x, y, z) -> self",
     "at once, N s"},
    {"mass", guard<soft_mass<Springs>>, "net:mass([i]) -> number", "of a point, or of all, kg"},
    {"pin", guard<soft_change<Springs, &Springs::pin>>, "net:pin(i) -> self", "holds a point where it is"},
    {"unpin", guard<soft_change<Springs, &Springs::unpin>>, "net:unpin(i) -> self", "lets it go"},
    {"pinned", guard<soft_pinned<Springs>>, "net:pinned(i) -> boolean", "is it held?"},
    {"attach", guard<soft_attach<Springs>>, "net:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame; to where it is when left out"},
    {"detach", guard<soft_change<Springs, &Springs::detach>>, "net:detach(i) -> self", "ends an attachment"},
    {"add_spring", guard<net_add_spring>,
     "net:add_spring(i, j, { stiffness =, damping =, rest_length =, break_strain =, tension_only =, power = }) -> k",
     "the new spring's number"},
    {"remove_spring", guard<net_remove_spring>, "net:remove_spring(k) -> self", "the others keep their numbers"},
    {"spring", guard<net_spring>, "net:spring(k) -> i, j, stiffness, damping, rest_length", "N/m, N s/m, m"},
    {"spring_limits", guard<net_spring_limits>, "net:spring_limits(k) -> break_strain, tension_only, power",
     "elongation / rest length where it breaks; does it only pull? power of the elongation in its force"},
    {"strain", guard<net_strain>, "net:strain([k]) -> number",
     "elongation / rest length; the largest when k is left out"},
    {"positions", guard<soft_vectors<Springs, &Springs::positions>>, "net:positions([buffer]) -> buffer",
     "x, y, z of all points; a new buffer when left out"},
};

}  // namespace

std::span<const Method> net_methods() { return kNetMethods; }

}  // namespace feder::lua
