// The methods of cloth. Vertices and edges count from 1.

#include <algorithm>

#include "lua/cloth_part.h"
#include "lua/soft.h"

namespace feder::lua {

template <>
struct SoftPoints<Cloth> {
  static constexpr const char* kOne = "vertex";
  static std::size_t count(const Cloth& cloth, ObjectId id) { return cloth.vertex_count(id); }
};

namespace {

using Sheet = Soft<Cloth>;

int cloth_count(lua_State* L) {
  const Sheet s(L);
  lua_pushinteger(L, static_cast<lua_Integer>(s.system.vertex_count(s.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(s.system.triangle_count(s.self.id)));
  lua_pushinteger(L, static_cast<lua_Integer>(s.system.edge_count(s.self.id)));
  return 3;
}

int cloth_strain(lua_State* L) {
  const Sheet s(L);
  if (lua_isnoneornil(L, 2)) {
    lua_pushnumber(L, s.system.max_strain(s.self.id));
    return 1;
  }
  const auto count = static_cast<std::int64_t>(s.system.edge_count(s.self.id));
  const auto k = check_integer(L, 2, std::string(function_name(L)) + ".edge", 1, count) - 1;
  lua_pushnumber(L, s.system.strain(s.self.id, static_cast<std::size_t>(k)));
  return 1;
}

int cloth_stretch(lua_State* L) {
  const Sheet s(L);
  lua_pushnumber(L, s.system.max_strain(s.self.id));
  return 1;
}

int cloth_triangles(lua_State* L) {
  const Sheet s(L);
  std::vector<std::uint32_t> list;
  s.system.triangles(s.self.id, list);
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
  const Sheet s(L);
  lua_pushinteger(L, s.system.substeps(s.self.id));
  return 1;
}

int cloth_awake(lua_State* L) {
  const Sheet s(L);
  lua_pushboolean(L, !s.system.asleep(s.self.id));
  return 1;
}

int cloth_wake(lua_State* L) {
  const Sheet s(L);
  s.system.wake(s.self.id);
  return return_self(L);
}

int cloth_sleep(lua_State* L) {
  const Sheet s(L);
  s.system.sleep(s.self.id);
  return return_self(L);
}

const Method kClothMethods[] = {
    {"count", guard<cloth_count>, "cloth:count() -> vertices, triangles, edges", "more after a tear"},
    {"point", guard<soft_read<Cloth, &Cloth::point>>, "cloth:point(i) -> x, y, z", "m"},
    {"set_point", guard<soft_write<Cloth, &Cloth::set_point>>, "cloth:set_point(i, x, y, z) -> self",
     "puts a vertex there at once"},
    {"velocity", guard<soft_read<Cloth, &Cloth::velocity>>, "cloth:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", guard<soft_write<Cloth, &Cloth::set_velocity>>, "cloth:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", guard<soft_write<Cloth, &Cloth::apply_impulse>>, "cloth:apply_impulse(i, x, y, z) -> self",
     "at once, N s"},
    {"mass", guard<soft_mass<Cloth>>, "cloth:mass([i]) -> number", "of a vertex, or of all, kg"},
    {"pin", guard<soft_change<Cloth, &Cloth::pin>>, "cloth:pin(i) -> self", "holds a vertex where it is"},
    {"unpin", guard<soft_change<Cloth, &Cloth::unpin>>, "cloth:unpin(i) -> self", "lets it go"},
    {"pinned", guard<soft_pinned<Cloth>>, "cloth:pinned(i) -> boolean", "is it held?"},
    {"attach", guard<soft_attach<Cloth>>, "cloth:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame; to where it is when left out"},
    {"detach", guard<soft_change<Cloth, &Cloth::detach>>, "cloth:detach(i) -> self", "ends an attachment"},
    {"strain", guard<cloth_strain>, "cloth:strain([k]) -> number",
     "elongation / rest length of an edge; the largest when k is left out"},
    {"stretch", guard<cloth_stretch>, "cloth:stretch() -> number", "largest edge strain now"},
    {"positions", guard<soft_vectors<Cloth, &Cloth::positions>>, "cloth:positions([buffer]) -> buffer", "as vertices"},
    {"vertices", guard<soft_vectors<Cloth, &Cloth::positions>>, "cloth:vertices([buffer]) -> buffer",
     "x, y, z of all vertices; a new buffer when left out"},
    {"smooth_vertices", guard<soft_vectors<Cloth, &Cloth::smooth_positions>>,
     "cloth:smooth_vertices([buffer]) -> buffer", "the same without wrinkles of one cell, for drawing"},
    {"normals", guard<soft_vectors<Cloth, &Cloth::normals>>, "cloth:normals([buffer]) -> buffer",
     "unit, one per vertex"},
    {"triangles", guard<cloth_triangles>, "cloth:triangles([buffer]) -> buffer", "three vertex numbers each"},
    {"substeps", guard<cloth_substeps>, "cloth:substeps() -> integer", "small steps per substep, as last chosen"},
    {"awake", guard<cloth_awake>, "cloth:awake() -> boolean", "does it move?"},
    {"wake", guard<cloth_wake>, "cloth:wake() -> self", "lets it move again"},
    {"sleep", guard<cloth_sleep>, "cloth:sleep() -> self", "stops it until something moves against it"},
};

}  // namespace

std::span<const Method> cloth_methods() { return kClothMethods; }

}  // namespace feder::lua
