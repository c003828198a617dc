// Soft bodies in Lua: their methods, and the part. Points and tetrahedra count from 1.
#include "lua/soft_part.h"

#include "lua/soft.h"
#include "lua/yaml_scene.h"

namespace feder::lua {

template <>
struct SoftPoints<Soft> {
  static constexpr const char* kOne = "point";
  static std::size_t count(const Soft& soft, ObjectId id) { return soft.point_count(id); }
};

namespace {

using SoftObject = Object<Soft>;

std::array<std::size_t, 2> soft_count(const SoftObject& s) {
  return {s.system.point_count(s.id), s.system.tetrahedron_count(s.id)};
}

std::size_t tetrahedron_argument(lua_State* L, const SoftObject& s) {
  return number_in(L, 2, s.system.tetrahedron_count(s.id), "tetrahedron");
}

// Of one tetrahedron, or the largest.
Real soft_strain(const SoftObject& s, lua_State* L) {
  if (lua_isnoneornil(L, 2)) return s.system.max_strain(s.id);
  return s.system.strain(s.id, tetrahedron_argument(L, s));
}

std::array<std::size_t, 4> soft_tetrahedron(const SoftObject& s, lua_State* L) {
  const auto t = s.system.tetrahedron(s.id, tetrahedron_argument(L, s));
  return {std::size_t(t[0]) + 1, std::size_t(t[1]) + 1, std::size_t(t[2]) + 1, std::size_t(t[3]) + 1};
}

// The tetrahedron at a place, and the weights of its points there; or nil.
int soft_tetrahedron_at(lua_State* L) {
  const SoftObject s(L);
  const Vec3 p = vector_argument(L, 2, false);
  std::array<double, 4> weights{};
  const std::size_t k = s.system.tetrahedron_at(s.id, p, weights);
  if (k == Soft::kNoTetrahedron) return push(L, nullptr);
  lua_pushinteger(L, static_cast<lua_Integer>(k) + 1);
  for (const double w : weights) lua_pushnumber(L, w);
  return 5;
}

Real soft_tension(const SoftObject& s, lua_State* L) { return s.system.tension(s.id, point_argument(L, s, 2)); }
std::size_t soft_part_of(const SoftObject& s, lua_State* L) { return s.system.part(s.id, point_argument(L, s, 2)) + 1; }

bool soft_awake(const SoftObject& s) { return !s.system.asleep(s.id); }
void soft_wake(const SoftObject& s) { s.system.wake(s.id); }

const Method kSoftMethods[] = {
    {"count", method<soft_count>, "soft:count() -> points, tetrahedra", "how many it has"},
    {"point", method<&Soft::point>, "soft:point(i) -> x, y, z", "m"},
    {"rest_point", method<&Soft::rest_point>, "soft:rest_point(i) -> x, y, z", "where it lies unstrained, local, m"},
    {"tetrahedron", method<soft_tetrahedron>, "soft:tetrahedron(k) -> i, j, k, l", "its four points"},
    {"tetrahedron_at", guard<soft_tetrahedron_at>, "soft:tetrahedron_at(x, y, z) -> k, number, number, number, number",
     "the tetrahedron at a place in the world, and the barycentric weights of its points there; nil outside"},
    {"set_point", method<&Soft::set_point>, "soft:set_point(i, x, y, z) -> self", "puts a point there at once"},
    {"velocity", method<&Soft::velocity>, "soft:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", method<&Soft::set_velocity>, "soft:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", method<&Soft::apply_impulse>, "soft:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", method<soft_mass<Soft>>, "soft:mass([i]) -> number", "of a point, or of all, kg"},
    {"pin", method<&Soft::pin>, "soft:pin(i) -> self", "holds a point where it is"},
    {"unpin", method<&Soft::unpin>, "soft:unpin(i) -> self", "lets it go"},
    {"pinned", method<&Soft::pinned>, "soft:pinned(i) -> boolean", "is it held?"},
    {"attach", method<soft_attach<Soft>>, "soft:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame, to where it is when left out; or to point [x] of a soft body, cloth, net or rope, "
     "the nearest"},
    {"detach", method<&Soft::detach>, "soft:detach(i) -> self", "ends all attachments of the point"},
    {"volume", method<&Soft::volume>, "soft:volume() -> number", "of all tetrahedra now, m3"},
    {"rest_volume", method<&Soft::rest_volume>, "soft:rest_volume() -> number", "unstrained, m3"},
    {"strain", method<soft_strain>, "soft:strain([k]) -> number",
     "largest elongation or shortening along any direction in a tetrahedron; the largest of all when k is left out"},
    {"tension", method<soft_tension>, "soft:tension(i) -> number",
     "largest tension along any direction at a point, the mean of the tetrahedra round it, Pa"},
    {"part", method<soft_part_of>, "soft:part(i) -> integer", "the part that the point belongs to, see parts"},
    {"parts", method<&Soft::part_count>, "soft:parts() -> integer",
     "how many pieces it is in, numbered by their first points"},
    {"inverted", method<&Soft::inverted>, "soft:inverted() -> integer", "tetrahedra that are turned inside out"},
    {"points", guard<list_vectors<Soft, &Soft::positions>>, "soft:points([buffer]) -> buffer",
     "x, y, z of all points; a new buffer when left out"},
    {"positions", guard<list_vectors<Soft, &Soft::positions>>, "soft:positions([buffer]) -> buffer",
     "the same, as nets and ropes call it"},
    {"substeps", method<&Soft::substeps>, "soft:substeps() -> integer", "solver substeps per substep, as last chosen"},
    {"awake", method<soft_awake>, "soft:awake() -> boolean", "does it move?"},
    {"wake", method<soft_wake>, "soft:wake() -> self", "lets it move again"},
    {"sleep", method<&Soft::sleep>, "soft:sleep() -> self", "stops it until something moves against it"},
};

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kSoftKind, &Soft::point_count); }

const Method kWorld[] = {
    {"soft", method<world_soft>, "world:soft{ points =, tetrahedra = | shape =, resolution =, ... } -> soft",
     "a volume that bends, squeezes and wobbles", soft_rows},
};
void yaml_soft(lua_State* L, int world) {
  make_shape_field(L, lua_gettop(L));
  make_object(L, world, "soft");
}

const YamlList kYaml[] = {{"soft_bodies", yaml_soft, "soft"}};

}  // namespace

const Part& soft_part() {
  static const ObjectClass classes[] = {{.name = "soft",
                                         .methods = kSoftMethods,
                                         .destroy = destroy_alone<&Soft::destroy_soft>,
                                         .contact_field = "index",
                                         .takes_forces = true}};
  static const Part part = {.name = "soft",
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_script_forces<Soft>};
  return part;
}

}  // namespace feder::lua
