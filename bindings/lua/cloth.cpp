// The methods of cloth. Vertices and edges count from 1.

#include <algorithm>

#include "lua/buffer.h"
#include "lua/cloth_part.h"

namespace feder::lua {
namespace {

struct Sheet {
  Self self;
  Cloth& cloth;
};

Sheet sheet(lua_State* L) {
  Self self = check_self(L);
  return {self, self.world.need<Cloth>()};
}

std::size_t vertex_argument(lua_State* L, const Sheet& s, int index = 2) {
  const std::size_t count = s.cloth.vertex_count(s.self.id);
  int whole = 0;
  const lua_Integer i = lua_type(L, index) == LUA_TNUMBER ? lua_tointegerx(L, index, &whole) : 0;
  if (whole && i >= 1 && static_cast<std::uint64_t>(i) <= count) return static_cast<std::size_t>(i - 1);
  fail_here(L, "expected a vertex from 1 to " + std::to_string(count) + ", got " + describe(L, index));
}

int cloth_count(lua_State* L) {
  const Sheet s = sheet(L);
  lua_pushinteger(L, static_cast<lua_Integer>(s.cloth.vertex_count(s.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(s.cloth.triangle_count(s.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(s.cloth.edge_count(s.self.id)));
  return 3;
}

int cloth_point(lua_State* L) {
  const Sheet s = sheet(L);
  return push_vector(L, s.cloth.point(s.self.id, vertex_argument(L, s)));
}

int cloth_set_point(lua_State* L) {
  const Sheet s = sheet(L);
  const std::size_t i = vertex_argument(L, s);
  s.cloth.set_point(s.self.id, i, vector_argument(L, 3, false));
  return return_self(L);
}

int cloth_velocity(lua_State* L) {
  const Sheet s = sheet(L);
  return push_vector(L, s.cloth.velocity(s.self.id, vertex_argument(L, s)));
}

int cloth_set_velocity(lua_State* L) {
  const Sheet s = sheet(L);
  const std::size_t i = vertex_argument(L, s);
  s.cloth.set_velocity(s.self.id, i, vector_argument(L, 3, false));
  return return_self(L);
}

int cloth_apply_impulse(lua_State* L) {
  const Sheet s = sheet(L);
  const std::size_t i = vertex_argument(L, s);
  s.cloth.apply_impulse(s.self.id, i, vector_argument(L, 3, false));
  return return_self(L);
}

int cloth_mass(lua_State* L) {
  const Sheet s = sheet(L);
  if (!lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, s.cloth.point_mass(s.self.id, vertex_argument(L, s)));
    return 1;
  }
  double sum = 0;
  for (std::size_t i = 0; i < s.cloth.vertex_count(s.self.id); ++i) sum += s.cloth.point_mass(s.self.id, i);
  lua_pushnumber(L, sum);
  return 1;
}

int cloth_pin(lua_State* L) {
  const Sheet s = sheet(L);
  s.cloth.pin(s.self.id, vertex_argument(L, s));
  return return_self(L);
}

int cloth_unpin(lua_State* L) {
  const Sheet s = sheet(L);
  s.cloth.unpin(s.self.id, vertex_argument(L, s));
  return return_self(L);
}

int cloth_pinned(lua_State* L) {
  const Sheet s = sheet(L);
  lua_pushboolean(L, s.cloth.pinned(s.self.id, vertex_argument(L, s)));
  return 1;
}

int cloth_attach(lua_State* L) {
  const Sheet s = sheet(L);
  const std::size_t i = vertex_argument(L, s);
  const ObjectId body = check_object(L, 3, s.self.record, std::string(function_name(L)) + ".body", "body");
  const Vec3 local = lua_isnoneornil(L, 4) ? to_local(pose_of(L, s.self.record, body), s.cloth.point(s.self.id, i))
                                           : vector_argument(L, 4, false);
  s.cloth.attach(s.self.id, i, body, local);
  return return_self(L);
}

int cloth_detach(lua_State* L) {
  const Sheet s = sheet(L);
  s.cloth.detach(s.self.id, vertex_argument(L, s));
  return return_self(L);
}

int cloth_strain(lua_State* L) {
  const Sheet s = sheet(L);
  if (lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, s.cloth.max_strain(s.self.id));
    return 1;
  }
  const auto count = static_cast<std::int64_t>(s.cloth.edge_count(s.self.id));
  const auto k = check_integer(L, 2, std::string(function_name(L)) + ".edge", 1, count) - 1;
  lua_pushnumber(L, s.cloth.strain(s.self.id, static_cast<std::size_t>(k)));
  return 1;
}

int cloth_stretch(lua_State* L) {
  const Sheet s = sheet(L);
  lua_pushnumber(L, s.cloth.max_strain(s.self.id));
  return 1;
}

template <void (Cloth::*Read)(ObjectId, std::vector<Vec3>&) const>
int cloth_vectors(lua_State* L) {
  const Sheet s = sheet(L);
  std::vector<Vec3> points;
  (s.cloth.*Read)(s.self.id, points);
  return push_vectors(L, points);
}

int cloth_triangles(lua_State* L) {
  const Sheet s = sheet(L);
  std::vector<std::uint32_t> list;
  s.cloth.triangles(s.self.id, list);
  std::span<double> out;
  if (lua_isnoneornil(L, 2)) {
    out = push_buffer(L, list.size());
  } else {
    out = test_buffer(L, 2);
    if (out.size() < list.size())
      fail_here(L, "expected a buffer of at least " + std::to_string(list.size()) + " numbers, got " +
                       (out.data() ? "one of " + std::to_string(out.size()) : describe(L, 2)));
    lua_settop(L, 2);
  }
  for (std::size_t i = 0; i < list.size(); ++i) out[i] = list[i] + 1;
  return 1;
}

int cloth_substeps(lua_State* L) {
  const Sheet s = sheet(L);
  lua_pushinteger(L, s.cloth.substeps(s.self.id));
  return 1;
}

int cloth_awake(lua_State* L) {
  const Sheet s = sheet(L);
  lua_pushboolean(L, !s.cloth.asleep(s.self.id));
  return 1;
}

int cloth_wake(lua_State* L) {
  const Sheet s = sheet(L);
  s.cloth.wake(s.self.id);
  return return_self(L);
}

int cloth_sleep(lua_State* L) {
  const Sheet s = sheet(L);
  s.cloth.sleep(s.self.id);
  return return_self(L);
}

const Method kClothMethods[] = {
    {"count", guard<cloth_count>, "cloth:count() -> vertices, triangles, edges", "more after a tear"},
    {"point", guard<cloth_point>, "cloth:point(i) -> x, y, z", "m"},
    {"set_point", guard<cloth_set_point>, "cloth:set_point(i, x, y, z) -> self", "puts a vertex there at once"},
    {"velocity", guard<cloth_velocity>, "cloth:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", guard<cloth_set_velocity>, "cloth:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", guard<cloth_apply_impulse>, "cloth:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", guard<cloth_mass>, "cloth:mass([i]) -> number", "of a vertex, or of all, kg"},
    {"pin", guard<cloth_pin>, "cloth:pin(i) -> self", "holds a vertex where it is"},
    {"unpin", guard<cloth_unpin>, "cloth:unpin(i) -> self", "lets it go"},
    {"pinned", guard<cloth_pinned>, "cloth:pinned(i) -> boolean", "is it held?"},
    {"attach", guard<cloth_attach>, "cloth:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame; to where it is when left out"},
    {"detach", guard<cloth_detach>, "cloth:detach(i) -> self", "ends an attachment"},
    {"strain", guard<cloth_strain>, "cloth:strain([k]) -> number",
     "elongation / rest length of an edge; the largest when k is left out"},
    {"stretch", guard<cloth_stretch>, "cloth:stretch() -> number", "largest edge strain now"},
    {"positions", guard<cloth_vectors<&Cloth::positions>>, "cloth:positions([buffer]) -> buffer", "as vertices"},
    {"vertices", guard<cloth_vectors<&Cloth::positions>>, "cloth:vertices([buffer]) -> buffer",
     "x, y, z of all vertices; a new buffer when left out"},
    {"smooth_vertices", guard<cloth_vectors<&Cloth::smooth_positions>>, "cloth:smooth_vertices([buffer]) -> buffer",
     "the same without wrinkles of one cell, for drawing"},
    {"normals", guard<cloth_vectors<&Cloth::normals>>, "cloth:normals([buffer]) -> buffer", "unit, one per vertex"},
    {"triangles", guard<cloth_triangles>, "cloth:triangles([buffer]) -> buffer", "three vertex numbers each"},
    {"substeps", guard<cloth_substeps>, "cloth:substeps() -> integer", "small steps per substep, as last chosen"},
    {"awake", guard<cloth_awake>, "cloth:awake() -> boolean", "does it move?"},
    {"wake", guard<cloth_wake>, "cloth:wake() -> self", "lets it move again"},
    {"sleep", guard<cloth_sleep>, "cloth:sleep() -> self", "stops it until something moves against it"},
};

}  // namespace

std::span<const Method> cloth_methods() { return kClothMethods; }

}  // namespace feder::lua
