// world:wind_sock{ ... }, its methods, and the list `wind_socks` of scenes in YAML.
#include "lua/objects.h"
#include "lua/stack.h"
#include "lua/yaml_scene.h"
#include "toy/parts.h"
#include "toy/wind_sock.h"

namespace feder::lua {
namespace {

WindSocks& socks(WorldRecord& record) { return record.world->need<WindSocks>(); }

constexpr Option<WindSockDesc> kWindSock[] = {
    field<&WindSockDesc::name>("name"),
    field<&WindSockDesc::position>("position", "m"),
    field<&WindSockDesc::wind>("wind", "m/s"),
    field<&WindSockDesc::segment>("segment", "m", kPositive),
    field<&WindSockDesc::lag>("lag", "s", kPositive),
    field<&WindSockDesc::count>("segments", "", {1, 1000}),
    later<WindSockDesc>("tags", kWordsType),
};
std::vector<OptionInfo> wind_sock_rows() { return describe_rows(kWindSock); }

int world_wind_sock(lua_State* L) {
  WorldRecord& r = check_world(L);
  Options o(L, 2, function_name(L), r.planar());
  WindSockDesc d;
  o.read(kWindSock, d);
  d.tags = tag_option(o, r);
  push_handle(L, r, socks(r).add(d));
  return 1;
}

int sock_tip(lua_State* L) {
  const Self self = check_self(L);
  std::vector<Vec3> points;
  socks(self.record).points(self.id, points);
  return push(L, points.back());
}

int sock_set_wind(lua_State* L) {
  const Self self = check_self(L);
  socks(self.record).set_wind(self.id, vector_argument(L, 2, self.record.planar()));
  return return_self(L);
}

int sock_asleep(lua_State* L) {
  const Self self = check_self(L);
  lua_pushboolean(L, socks(self.record).asleep(self.id));
  return 1;
}

std::vector<ObjectId> destroy(WorldRecord& record, ObjectId id, const std::string& where) {
  socks(record).destroy(id, where);
  return {};
}

const Method kMethods[] = {
    {"tip", guard<sock_tip>, "wind_sock:tip() -> x, y, z", "of its last point, m"},
    {"set_wind", guard<sock_set_wind>, "wind_sock:set_wind(x, y, z) -> self", "m/s; wakes it"},
    {"asleep", guard<sock_asleep>, "wind_sock:asleep() -> boolean", "does it hang still?"},
};
const Method kWorld[] = {
    {"wind_sock", guard<world_wind_sock>,
     "world:wind_sock{ position =, wind =, segments =, segment =, lag = } -> wind_sock", "trails from a mast",
     wind_sock_rows},
};
const ObjectClass kClasses[] = {{.name = "wind_sock", .methods = kMethods, .destroy = &destroy}};
const YamlList kYaml[] = {{"wind_socks", [](lua_State* L, int world) { make_object(L, world, "wind_sock"); }}};

}  // namespace

const Part& wind_sock_part() {
  static const Part part = {.name = "wind_socks", .functions = {}, .world = kWorld, .classes = kClasses, .yaml = kYaml};
  return part;
}

}  // namespace feder::lua
