#include "lua/springs_part.h"

#include "lua/advice.h"
#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

std::vector<ObjectId> destroy_net(WorldRecord& record, ObjectId id, const std::string& where) {
  record.world->need<Springs>().destroy_net(id, where);
  return {};
}

std::size_t point_count(WorldRecord& record, ObjectId id) { return record.world->need<Springs>().point_count(id); }

void clear_forces(World& world) {
  if (Springs* springs = world.find<Springs>()) springs->clear_script_forces();
}

void apply_forces(ForceRun& run) {
  World& world = *run.record().world;
  Springs* springs = world.find<Springs>();
  if (!springs) return;
  springs->clear_script_forces();
  std::vector<ObjectId> nets;
  world.objects().for_each(kNetKind, [&](ObjectId id) { nets.push_back(id); });
  std::vector<Vec3> positions;
  for (const ObjectId net : nets) {
    if (!world.objects().alive(net) || !run.any(net)) continue;
    springs->positions(net, positions);
    for (std::size_t i = 0; i < positions.size() && world.objects().alive(net); ++i) {
      const Vec3 force = run.sum(net, static_cast<std::uint32_t>(i), positions[i], springs->velocity(net, i),
                                 springs->point_mass(net, i));
      if (world.objects().alive(net) && dot(force, force) > 0) springs->set_script_force(net, i, force);
    }
  }
}

const Method kFunctions[] = {
    {"advise", guard<feder_advise>,
     "feder.advise(world) -> {{ object =, text =, verdict =, method =, limit =, h =, hw =, substeps =, integrator =, "
     "error_class =, resolved_hertz =, ... }, ...}",
     "per net: is the step stable, how large are its errors, what would do"},
};
const Method kWorld[] = {
    {"net", guard<world_net>, "world:net{ points =, springs =, ... } -> net", "mass points and springs"},
};
const YamlList kYaml[] = {{"nets", [](lua_State* L, int world) { make_object(L, world, "net"); }}};

}  // namespace

const Part& springs_part() {
  static const ObjectClass classes[] = {{.name = "net",
                                         .methods = net_methods(),
                                         .destroy = &destroy_net,
                                         .place = "index",
                                         .takes_forces = true,
                                         .point_count = &point_count}};
  static const Part part = {.name = "springs",
                            .functions = kFunctions,
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_forces};
  return part;
}

}  // namespace feder::lua
