#include "lua/cloth_part.h"

#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

void apply_forces(ForceRun& run) { apply_to_points(run, *run.record().world, kClothKind, &Cloth::vertex_count); }

const Method kWorld[] = {
    {"cloth", method<world_cloth>, "world:cloth{ size =, resolution = | vertices =, triangles =, ... } -> cloth",
     "a sheet or a triangle mesh", cloth_rows},
};
const YamlList kYaml[] = {{"cloths", [](lua_State* L, int world) { make_object(L, world, "cloth"); }}};

}  // namespace

const Part& cloth_part() {
  static const ObjectClass classes[] = {{.name = "cloth",
                                         .methods = cloth_methods(),
                                         .destroy = destroy_alone<&Cloth::destroy_cloth>,
                                         .contact_field = "index",
                                         .takes_forces = true}};
  static const Part part = {.name = "cloth",
                            .functions = {},
                            .world = kWorld,
                            .classes = classes,
                            .yaml = kYaml,
                            .apply_forces = &apply_forces,
                            .clear_forces = &clear_script_forces<Cloth>};
  return part;
}

}  // namespace feder::lua
