// The methods of nets. Points and springs count from 1.
#include <algorithm>

#include "lua/buffer.h"
#include "lua/springs_part.h"

namespace feder::lua {
namespace {

struct Net {
  Self self;
  Springs& springs;
  bool planar() const { return self.record.planar(); }
};

Net net(lua_State* L) {
  Self self = check_self(L);
  return {self, self.record.world->need<Springs>()};
}

std::size_t number_in(lua_State* L, int index, std::size_t count, const char* what) {
  int whole = 0;
  const lua_Integer i = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : 0;
  if (whole && i >= 1 && static_cast<std::uint64_t>(i) <= count) return static_cast<std::size_t>(i - 1);
  fail_here(L,
            std::string("expected a ") + what + " from 1 to " + std::to_string(count) + ", got " + describe(L, index));
}

std::size_t point_argument(lua_State* L, const Net& n, int index = 2) {
  return number_in(L, index, n.springs.point_count(n.self.id), "point");
}
std::size_t spring_argument(lua_State* L, const Net& n) {
  return number_in(L, 2, n.springs.spring_count(n.self.id), "spring");
}

int net_count(lua_State* L) {
  const Net n = net(L);
  lua_pushinteger(L, static_cast<lua_Integer>(n.springs.point_count(n.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(n.springs.spring_count(n.self.id)));
  return 2;
}

int net_point(lua_State* L) {
  const Net n = net(L);
  return push_vector(L, n.springs.point(n.self.id, point_argument(L, n)));
}

int net_set_point(lua_State* L) {
  const Net n = net(L);
  const std::size_t i = point_argument(L, n);
  n.springs.set_point(n.self.id, i, vector_argument(L, 3, n.planar()));
  return return_self(L);
}

int net_velocity(lua_State* L) {
  const Net n = net(L);
  return push_vector(L, n.springs.velocity(n.self.id, point_argument(L, n)));
}

int net_set_velocity(lua_State* L) {
  const Net n = net(L);
  const std::size_t i = point_argument(L, n);
  n.springs.set_velocity(n.self.id, i, vector_argument(L, 3, n.planar()));
  return return_self(L);
}

int net_apply_impulse(lua_State* L) {
  const Net n = net(L);
  const std::size_t i = point_argument(L, n);
  n.springs.apply_impulse(n.self.id, i, vector_argument(L, 3, n.planar()));
  return return_self(L);
}

int net_mass(lua_State* L) {
  const Net n = net(L);
  if (!lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, n.springs.point_mass(n.self.id, point_argument(L, n)));
    return 1;
  }
  double sum = 0;
  for (std::size_t i = 0; i < n.springs.point_count(n.self.id); ++i) sum += n.springs.point_mass(n.self.id, i);
  lua_pushnumber(L, sum);
  return 1;
}

int net_pin(lua_State* L) {
  const Net n = net(L);
  n.springs.pin(n.self.id, point_argument(L, n));
  return return_self(L);
}

int net_unpin(lua_State* L) {
  const Net n = net(L);
  n.springs.unpin(n.self.id, point_argument(L, n));
  return return_self(L);
}

int net_pinned(lua_State* L) {
  const Net n = net(L);
  lua_pushboolean(L, n.springs.pinned(n.self.id, point_argument(L, n)));
  return 1;
}

int net_attach(lua_State* L) {
  const Net n = net(L);
  const std::size_t i = point_argument(L, n);
  const ObjectId body = check_object(L, 3, n.self.record, std::string(function_name(L)) + ".body", "body");
  const Vec3 local = lua_isnoneornil(L, 4) ? to_local(pose_of(L, n.self.record, body), n.springs.point(n.self.id, i))
                                           : vector_argument(L, 4, n.planar());
  n.springs.attach(n.self.id, i, body, local);
  return return_self(L);
}

int net_detach(lua_State* L) {
  const Net n = net(L);
  n.springs.detach(n.self.id, point_argument(L, n));
  return return_self(L);
}

// add_spring(i, j, { stiffness = ... }) or add_spring{ i, j, stiffness = ... }.
int net_add_spring(lua_State* L) {
  const Net n = net(L);
  const std::size_t count = n.springs.point_count(n.self.id);
  if (lua_type(L, 2) != LUA_TTABLE) {
    const std::size_t i = point_argument(L, n, 2), j = point_argument(L, n, 3);
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
  if (s.rest_length < 0 && !(length(n.springs.point(n.self.id, s.i) - n.springs.point(n.self.id, s.j)) > 0))
    fail_here(L, "the points are at the same place; expected a rest_length, got nil");
  lua_pushinteger(L, static_cast<lua_Integer>(n.springs.add_spring(n.self.id, s)) + 1);
  return 1;
}

int net_remove_spring(lua_State* L) {
  const Net n = net(L);
  n.springs.remove_spring(n.self.id, spring_argument(L, n));
  return return_self(L);
}

int net_strain(lua_State* L) {
  const Net n = net(L);
  if (!lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, n.springs.strain(n.self.id, spring_argument(L, n)));
    return 1;
  }
  Real largest = 0;
  for (std::size_t k = 0; k < n.springs.spring_count(n.self.id); ++k)
    largest = std::max(largest, n.springs.strain(n.self.id, k));
  lua_pushnumber(L, largest);
  return 1;
}

int net_spring(lua_State* L) {
  const Net n = net(L);
  const SpringDesc s = n.springs.spring(n.self.id, spring_argument(L, n));
  lua_pushinteger(L, static_cast<lua_Integer>(s.i) + 1);
  lua_pushinteger(L, static_cast<lua_Integer>(s.j) + 1);
  lua_pushnumber(L, s.stiffness), lua_pushnumber(L, s.damping), lua_pushnumber(L, s.rest_length);
  return 5;
}

int net_spring_limits(lua_State* L) {
  const Net n = net(L);
  const SpringDesc s = n.springs.spring(n.self.id, spring_argument(L, n));
  lua_pushnumber(L, s.break_strain), lua_pushboolean(L, s.tension_only), lua_pushinteger(L, s.power);
  return 3;
}

int net_positions(lua_State* L) {
  const Net n = net(L);
  std::vector<Vec3> points;
  n.springs.positions(n.self.id, points);
  return push_vectors(L, points);
}

const Method kNetMethods[] = {
    {"count", guard<net_count>, "net:count() -> points, springs",
     "how many it has; removed springs keep their numbers"},
    {"point", guard<net_point>, "net:point(i) -> x, y, z", "m"},
    {"set_point", guard<net_set_point>, "net:set_point(i, x, y, z) -> self", "puts a point there at once"},
    {"velocity", guard<net_velocity>, "net:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", guard<net_set_velocity>, "net:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", guard<net_apply_impulse>, "net:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", guard<net_mass>, "net:mass([i]) -> number", "of a point, or of all, kg"},
    {"pin", guard<net_pin>, "net:pin(i) -> self", "holds a point where it is"},
    {"unpin", guard<net_unpin>, "net:unpin(i) -> self", "lets it go"},
    {"pinned", guard<net_pinned>, "net:pinned(i) -> boolean", "is it held?"},
    {"attach", guard<net_attach>, "net:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame; to where it is when left out"},
    {"detach", guard<net_detach>, "net:detach(i) -> self", "ends an attachment"},
    {"add_spring", guard<net_add_spring>,
     "net:add_spring(i, j, { stiffness =, damping =, rest_length =, break_strain =, tension_only =, power = }) -> k",
     "the new spring's number"},
    {"remove_spring", guard<net_remove_spring>, "net:remove_spring(k) -> self", "the others keep their numbers"},
    {"spring", guard<net_spring>, "net:spring(k) -> i, j, stiffness, damping, rest_length", "N/m, N s/m, m"},
    {"spring_limits", guard<net_spring_limits>, "net:spring_limits(k) -> break_strain, tension_only, power",
     "elongation / rest length where it breaks; does it only pull? power of the elongation in its force"},
    {"strain", guard<net_strain>, "net:strain([k]) -> number",
     "elongation / rest length; the largest when k is left out"},
    {"positions", guard<net_positions>, "net:positions([buffer]) -> buffer",
     "x, y, z of all points; a new buffer when left out"},
};

}  // namespace

std::span<const Method> net_methods() { return kNetMethods; }

}  // namespace feder::lua
