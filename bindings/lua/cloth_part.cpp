// Cloth in Lua: its methods, and the part. Vertices and edges count from 1.
#include "lua/cloth_part.h"

#include "lua/soft.h"
#include "lua/yaml_scene.h"

namespace feder::lua {

template <>
struct SoftPoints<Cloth> {
  static constexpr const char* kOne = "vertex";
  static std::size_t count(const Cloth& cloth, ObjectId id) { return cloth.vertex_count(id); }
};

namespace {

using Sheet = Object<Cloth>;

std::array<std::size_t, 3> cloth_count(const Sheet& s) {
  return {s.system.vertex_count(s.id), s.system.triangle_count(s.id), s.system.edge_count(s.id)};
}

// Of one edge, or the largest.
Real cloth_strain(const Sheet& s, lua_State* L) {
  if (lua_isnoneornil(L, 2)) return s.system.max_strain(s.id);
  const auto count = static_cast<std::int64_t>(s.system.edge_count(s.id));
  const auto k = check_integer(L, 2, std::string(function_name(L)) + ".edge", 1, count) - 1;
  return s.system.strain(s.id, static_cast<std::size_t>(k));
}

int cloth_triangles(lua_State* L) {
  const Sheet s(L);
  std::vector<std::uint32_t> list;
  s.system.triangles(s.id, list);
  const std::span<double> out = push_output(L, list.size());
  for (std::size_t i = 0; i < list.size(); ++i) out[i] = list[i] + 1;
  return 1;
}

void cloth_set_pressure(const Sheet& s, lua_State* L) {
  s.system.set_pressure(
      s.id, static_cast<Real>(check_number(L, 2, std::string(function_name(L)) + ".pressure", kNotNegative)));
}

bool cloth_awake(const Sheet& s) { return !s.system.asleep(s.id); }
void cloth_wake(const Sheet& s) { s.system.wake(s.id); }

const Method kClothMethods[] = {
    {"count", method<cloth_count>, "cloth:count() -> vertices, triangles, edges", "more after a tear"},
    {"point", method<&Cloth::point>, "cloth:point(i) -> x, y, z", "m"},
    {"set_point", method<&Cloth::set_point>, "cloth:set_point(i, x, y, z) -> self", "puts a vertex there at once"},
    {"velocity", method<&Cloth::velocity>, "cloth:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", method<&Cloth::set_velocity>, "cloth:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", method<&Cloth::apply_impulse>, "cloth:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", method<soft_mass<Cloth>>, "cloth:mass([i]) -> number", "of a vertex, or of all, kg"},
    {"pin", method<&Cloth::pin>, "cloth:pin(i) -> self", "holds a vertex where it is"},
    {"unpin", method<&Cloth::unpin>, "cloth:unpin(i) -> self", "lets it go"},
    {"pinned", method<&Cloth::pinned>, "cloth:pinned(i) -> boolean", "is it held?"},
    {"attach", method<soft_attach<Cloth>>, "cloth:attach(i, body, [x, y, z]) -> self",
     "a vertex, or of a sheet \"top_left\", \"top\" ..., to a point of the body frame, to where it is when left out; "
     "or to "
     "point [x] of a cloth, net, rope or soft body, the nearest"},
    {"detach", method<&Cloth::detach>, "cloth:detach(i) -> self", "ends an attachment"},
    {"strain", method<cloth_strain>, "cloth:strain([k]) -> number",
     "elongation / rest length of an edge; the largest when k is left out"},
    {"stretch", method<&Cloth::max_strain>, "cloth:stretch() -> number", "largest edge strain now"},
    {"tangles", method<&Cloth::tangles>, "cloth:tangles() -> integer",
     "edges that pass through its own triangles now, counted by pairs"},
    {"volume", method<&Cloth::volume>, "cloth:volume() -> number", "within a closed mesh, m3"},
    {"pressure", method<&Cloth::pressure>, "cloth:pressure() -> number",
     "of the gas in a closed mesh over that outside, Pa"},
    {"set_pressure", method<cloth_set_pressure>, "cloth:set_pressure(pressure) -> self",
     "of the gas in a closed mesh, Pa"},
    {"positions", guard<list_vectors<Cloth, &Cloth::positions>>, "cloth:positions([buffer]) -> buffer", "as vertices"},
    {"vertices", guard<list_vectors<Cloth, &Cloth::positions>>, "cloth:vertices([buffer]) -> buffer",
     "x, y, z of all vertices; a new buffer when left out"},
    {"smooth_vertices", guard<list_vectors<Cloth, &Cloth::smooth_positions>>,
     "cloth:smooth_vertices([buffer]) -> buffer", "the same without wrinkles of one cell, for drawing"},
    {"normals", guard<list_vectors<Cloth, &Cloth::normals>>, "cloth:normals([buffer]) -> buffer",
     "unit, one per vertex"},
    {"triangles", guard<cloth_triangles>, "cloth:triangles([buffer]) -> buffer", "three vertex numbers each"},
    {"substeps", method<&Cloth::substeps>, "cloth:substeps() -> integer",
     "solver substeps per substep, as last chosen"},
    {"awake", method<cloth_awake>, "cloth:awake() -> boolean", "does it move?"},
    {"wake", method<cloth_wake>, "cloth:wake() -> self", "lets it move again"},
    {"sleep", method<&Cloth::sleep>, "cloth:sleep() -> self", "stops it until something moves against it"},
};

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kClothKind, &Cloth::vertex_count); }

const Method kWorld[] = {
    {"cloth", method<world_cloth>, "world:cloth{ size =, resolution = | vertices =, triangles =, ... } -> cloth",
     "a sheet or a triangle mesh", cloth_rows},
};
const YamlList kYaml[] = {{"cloths", [](lua_State* L, int world) { make_object(L, world, "cloth"); }, "cloth"}};

}  // namespace

const Part& cloth_part() {
  static const ObjectClass classes[] = {{.name = "cloth",
                                         .methods = kClothMethods,
                                         .destroy = destroy_alone<&Cloth::destroy_cloth>,
                                         .contact_field = "index",
                                         .takes_forces = true}};
  static const Part part = {.name = "cloth",
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_script_forces<Cloth>};
  return part;
}

}  // namespace feder::lua
