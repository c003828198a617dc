#include "lua/springs_part.h"

#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

std::size_t point_count(WorldRecord& record, ObjectId id) { return record.world->need<Springs>().point_count(id); }

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kNetKind, &Springs::point_count); }

const Method kWorld[] = {
    {"net", method<world_net>, "world:net{ points =, springs =, ... } -> net", "mass points and springs", net_rows},
};
const YamlList kYaml[] = {{"nets", [](lua_State* L, int world) { make_object(L, world, "net"); }}};

}  // namespace

const Part& springs_part() {
  static const ObjectClass classes[] = {{.name = "net",
                                         .methods = net_methods(),
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
