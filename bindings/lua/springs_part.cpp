// Nets in Lua: their methods, and the part "springs". Points and springs count from 1.
#include "lua/springs_part.h"

#include <algorithm>

#include "lua/soft.h"
#include "lua/yaml_scene.h"

namespace feder::lua {

template <>
struct SoftPoints<Springs> {
  static constexpr const char* kOne = "point";
  static std::size_t count(const Springs& springs, ObjectId id) { return springs.point_count(id); }
};

namespace {

using Net = Object<Springs>;

std::size_t spring_argument(lua_State* L, const Net& n) {
  return number_in(L, 2, n.system.spring_count(n.id), "spring");
}

std::array<std::size_t, 2> net_count(const Net& n) { return {n.system.point_count(n.id), n.system.spring_count(n.id)}; }

// add_spring(i, j, { stiffness = ... }) or add_spring{ i, j, stiffness = ... }.
std::size_t net_add_spring(const Net& n, lua_State* L) {
  if (lua_type(L, 2) != LUA_TTABLE) {
    const std::size_t i = point_argument(L, n, 2), j = point_argument(L, n, 3);
    lua_newtable(L);
    if (lua_type(L, 4) == LUA_TTABLE) copy_fields(L, 4);
    push(L, i + 1), lua_rawseti(L, -2, 1);
    push(L, j + 1), lua_rawseti(L, -2, 2);
    lua_replace(L, 2);
    lua_settop(L, 2);
  }
  Options o(L, 2, function_name(L));
  const SpringDesc s = read_spring(o, n.system.point_count(n.id));
  if (s.rest_length < 0 && !(length(n.system.point(n.id, s.i) - n.system.point(n.id, s.j)) > 0))
    fail_here(L, "the points are at the same place; expected a rest_length, got nil");
  return n.system.add_spring(n.id, s) + 1;
}

void net_remove_spring(const Net& n, lua_State* L) { n.system.remove_spring(n.id, spring_argument(L, n)); }

Real net_strain(const Net& n, lua_State* L) {
  if (!lua_isnoneornil(L, 2)) return n.system.strain(n.id, spring_argument(L, n));
  Real largest = 0;
  for (std::size_t k = 0; k < n.system.spring_count(n.id); ++k) largest = std::max(largest, n.system.strain(n.id, k));
  return largest;
}

int net_spring(lua_State* L) {
  const Net n(L);
  const SpringDesc s = n.system.spring(n.id, spring_argument(L, n));
  return push(L, s.i + 1, s.j + 1, s.stiffness, s.damping, s.rest_length);
}

int net_spring_limits(lua_State* L) {
  const Net n(L);
  const SpringDesc s = n.system.spring(n.id, spring_argument(L, n));
  return push(L, s.break_strain, s.tension_only, s.power);
}

const Method kNetMethods[] = {
    {"count", method<net_count>, "net:count() -> points, springs",
     "how many it has; removed springs keep their numbers"},
    {"point", method<&Springs::point>, "net:point(i) -> x, y, z", "m"},
    {"set_point", method<&Springs::set_point>, "net:set_point(i, x, y, z) -> self", "puts a point there at once"},
    {"velocity", method<&Springs::velocity>, "net:velocity(i) -> x, y, z", "m/s"},
    {"set_velocity", method<&Springs::set_velocity>, "net:set_velocity(i, x, y, z) -> self", "m/s"},
    {"apply_impulse", method<&Springs::apply_impulse>, "net:apply_impulse(i, x, y, z) -> self", "at once, N s"},
    {"mass", method<soft_mass<Springs>>, "net:mass([i]) -> number", "of a point, or of all, kg"},
    {"pin", method<&Springs::pin>, "net:pin(i) -> self", "holds a point where it is"},
    {"unpin", method<&Springs::unpin>, "net:unpin(i) -> self", "lets it go"},
    {"pinned", method<&Springs::pinned>, "net:pinned(i) -> boolean", "is it held?"},
    {"attach", method<soft_attach<Springs>>, "net:attach(i, body, [x, y, z]) -> self",
     "to a point of the body frame, to where it is when left out; or to point [x] of a net, cloth, rope or soft "
     "body, the nearest"},
    {"detach", method<&Springs::detach>, "net:detach(i) -> self", "ends an attachment"},
    {"add_spring", method<net_add_spring>,
     "net:add_spring(i, j, { stiffness =, damping =, rest_length =, break_strain =, tension_only =, power = }) -> k",
     "the new spring's number"},
    {"remove_spring", method<net_remove_spring>, "net:remove_spring(k) -> self", "the others keep their numbers"},
    {"spring", guard<net_spring>, "net:spring(k) -> i, j, stiffness, damping, rest_length", "N/m, N s/m, m"},
    {"spring_limits", guard<net_spring_limits>, "net:spring_limits(k) -> break_strain, tension_only, power",
     "elongation / rest length where it breaks; does it only pull? power of the elongation in its force"},
    {"strain", method<net_strain>, "net:strain([k]) -> number",
     "elongation / rest length; the largest when k is left out"},
    {"positions", guard<list_vectors<Springs, &Springs::positions>>, "net:positions([buffer]) -> buffer",
     "x, y, z of all points; a new buffer when left out"},
};

std::size_t point_count(WorldRecord& record, ObjectId id) { return system_of<Springs>(record).point_count(id); }

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kNetKind, &Springs::point_count); }

const Method kWorld[] = {
    {"net", method<world_net>, "world:net{ points =, springs =, ... } -> net", "mass points and springs", net_rows},
};
const YamlList kYaml[] = {{"nets", [](lua_State* L, int world) { make_object(L, world, "net"); }, "net"}};

}  // namespace

const Part& springs_part() {
  static const ObjectClass classes[] = {{.name = "net",
                                         .methods = kNetMethods,
                                         .destroy = destroy_alone<&Springs::destroy_net>,
                                         .contact_field = "index",
                                         .takes_forces = true,
                                         .point_count = &point_count}};
  static const Part part = {.name = "springs",
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_script_forces<Springs>,
                            .advise = &advise_nets};
  return part;
}

}  // namespace feder::lua
