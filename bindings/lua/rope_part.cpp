// Ropes in Lua: their methods, and the part. Points and segments count from 1.
#include "lua/rope_part.h"

#include "lua/soft.h"
#include "lua/yaml_scene.h"

namespace feder::lua {

template <>
struct SoftPoints<Rope> {
  static constexpr const char* kOne = "point";
  static std::size_t count(const Rope& ropes, ObjectId id) { return ropes.point_count(id); }
};

namespace {

using RopeObject = Object<Rope>;

std::array<std::size_t, 2> rope_count(const RopeObject& r) {
  const std::size_t points = r.system.point_count(r.id);
  return {points, points - 1};
}

std::size_t segment_argument(lua_State* L, const RopeObject& r) {
  return number_in(L, 2, r.system.point_count(r.id) - 1, "segment");
}

// Of one segment, or the largest.
Real rope_strain(const RopeObject& r, lua_State* L) {
  if (lua_isnoneornil(L, 2)) return r.system.max_strain(r.id);
  return r.system.strain(r.id, segment_argument(L, r));
}

Real rope_tension(const RopeObject& r, lua_State* L) { return r.system.tension(r.id, segment_argument(L, r)); }
bool rope_awake(const RopeObject& r) { return !r.system.asleep(r.id); }
void rope_wake(const RopeObject& r) { r.system.wake(r.id); }

const Method kRopeMethods[] = {
    {"count", method<rope_count>, "rope:count() -> points, segments", "how many it has"},
    {"point", method<&Rope::point>, "rope:point(i) -> x, y, z", "m"},
    {"set_point", method<&Rope::set_point>, "rope:set_point(i, x, y, z) -> self", "puts a point there at once"},
    {"velocity", method<&Rope::velocity>, "rope:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", method<&Rope::set_velocity>, "rope:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", method<&Rope::apply_impulse>, "rope:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", method<soft_mass<Rope>>, "rope:mass([i]) -> number", "of a point, or of all, kg"},
    {"pin", method<&Rope::pin>, "rope:pin(i) -> self", "holds a point where it is"},
    {"unpin", method<&Rope::unpin>, "rope:unpin(i) -> self", "lets it go, and the clamp of an end too"},
    {"pinned", method<&Rope::pinned>, "rope:pinned(i) -> boolean", "is it held?"},
    {"attach", method<soft_attach<Rope>>, "rope:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame, to where it is when left out; or to point [x] of a rope, net, cloth or soft "
     "body, the nearest"},
    {"detach", method<&Rope::detach>, "rope:detach(i) -> self", "ends all attachments of the point"},
    {"strain", method<rope_strain>, "rope:strain([k]) -> number",
     "elongation / rest length of a segment; the largest when k is left out"},
    {"tension", method<rope_tension>, "rope:tension(k) -> number", "that strain times stretch, N"},
    {"length", method<&Rope::current_length>, "rope:length() -> number", "along its segments now, m"},
    {"positions", guard<list_vectors<Rope, &Rope::positions>>, "rope:positions([buffer]) -> buffer",
     "x, y, z of all points; a new buffer when left out"},
    {"substeps", method<&Rope::substeps>, "rope:substeps() -> integer", "solver substeps per substep, as last chosen"},
    {"awake", method<rope_awake>, "rope:awake() -> boolean", "does it move?"},
    {"wake", method<rope_wake>, "rope:wake() -> self", "lets it move again"},
    {"sleep", method<&Rope::sleep>, "rope:sleep() -> self", "stops it until something moves against it"},
};

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kRopeKind, &Rope::point_count); }

const Method kWorld[] = {
    {"rope", method<world_rope>, "world:rope{ points = | from =, to =, segments =, ... } -> rope",
     "a chain of segments with thickness, without twist", rope_rows},
};
const YamlList kYaml[] = {{"ropes", [](lua_State* L, int world) { make_object(L, world, "rope"); }, "rope"}};

}  // namespace

const Part& rope_part() {
  static const ObjectClass classes[] = {{.name = "rope",
                                         .methods = kRopeMethods,
                                         .destroy = destroy_alone<&Rope::destroy_rope>,
                                         .contact_field = "index",
                                         .takes_forces = true}};
  static const Part part = {.name = "rope",
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_script_forces<Rope>};
  return part;
}

}  // namespace feder::lua
