#include "lua/cloth_part.h"

#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

std::vector<ObjectId> destroy_cloth(WorldRecord& record, ObjectId id, const std::string& where) {
  record.world->need<Cloth>().destroy_cloth(id, where);
  return {};
}

void clear_forces(World& world) {
  if (Cloth* cloth = world.find<Cloth>()) cloth->clear_script_forces();
}

void apply_forces(ForceRun& run) {
  World& world = *run.record().world;
  Cloth* cloth = world.find<Cloth>();
  if (!cloth) return;
  cloth->clear_script_forces();
  const Objects& objects = world.objects();
  std::vector<ObjectId> all;
  objects.for_each(kClothKind, [&](ObjectId id) { all.push_back(id); });
  for (const ObjectId id : all) {
    if (!objects.alive(id) || !run.any(id)) continue;
    for (std::size_t i = 0; objects.alive(id) && i < cloth->vertex_count(id); ++i) {
      const Vec3 force = run.sum(id, static_cast<std::uint32_t>(i), cloth->point(id, i), cloth->velocity(id, i),
                                 cloth->point_mass(id, i));
      if (objects.alive(id) && dot(force, force) > 0) cloth->set_script_force(id, i, force);
    }
  }
}

const Method kWorld[] = {
    {"cloth", guard<world_cloth>, "world:cloth{ size =, resolution = | vertices =, triangles =, ... } -> cloth",
     "a sheet or a triangle mesh; see section 6"},
};
const YamlList kYaml[] = {{"cloths", [](lua_State* L, int world) { make_object(L, world, "cloth"); }}};

}  // namespace

const Part& cloth_part() {
  static const ObjectClass classes[] = {
      {.name = "cloth", .methods = cloth_methods(), .destroy = &destroy_cloth, .place = "index", .takes_forces = true}};
  static const Part part = {.name = "cloth",
                            .functions = {},
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_forces};
  return part;
}

}  // namespace feder::lua
