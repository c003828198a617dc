#include "lua/fluid_part.h"

#include "lua/shapes.h"
#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

std::vector<ObjectId> destroy_fluid(WorldRecord& record, ObjectId id, const std::string& where) {
  Fluid& fluid = record.world->need<Fluid>();
  std::vector<ObjectId> sources;  // go with it
  for (const ObjectKind kind : {kEmitterKind, kDrainKind})
    record.world->objects().for_each(kind, [&](ObjectId source) {
      if (fluid.fluid_of(source) == id) sources.push_back(source);
    });
  fluid.destroy_fluid(id, where);
  return sources;
}

// A fluid with its fill, emitters and drains: each a table or a list of tables of the method of that name.
void make_fluid(lua_State* L, int world) {
  const int options = lua_gettop(L);
  lua_newtable(L);  // the options without them
  copy_locations(L, options, -1);
  copy_fields(L, options);
  for (const char* part : {"fill", "emitter", "drain"}) set_field(L, part, nullptr);
  call_maker(L, world, "fluid", options + 1, 1);
  const int fluid = lua_gettop(L);
  for (const char* part : {"fill", "emitter", "drain"}) {
    const auto make = [&](int entry) {
      if (lua_type(L, entry) == LUA_TTABLE) make_shape_field(L, entry);
      call_maker(L, fluid, part, entry, 0);
    };
    if (lua_getfield(L, options, part) == LUA_TTABLE && lua_rawlen(L, -1) > 0)
      each_entry(L, -1, [&](lua_Integer) { make(lua_gettop(L)); });
    else if (lua_type(L, -1) == LUA_TTABLE)
      make(lua_gettop(L));
    lua_settop(L, fluid);
  }
  lua_settop(L, options - 1);
}

const Method kWorld[] = {
    {"fluid", method<world_fluid>, "world:fluid{ spacing =, density =, viscosity =, solver =, ... } -> fluid",
     "particles of a liquid", fluid_rows},
};
const YamlList kYaml[] = {{"fluids", make_fluid}};

}  // namespace

const Part& fluid_part() {
  static const ObjectClass classes[] = {
      {.name = "fluid", .methods = fluid_methods(), .destroy = &destroy_fluid, .contact_field = "count"},
      {.name = "emitter", .methods = emitter_methods(), .destroy = destroy_alone<&Fluid::destroy_emitter>},
      {.name = "drain", .methods = drain_methods(), .destroy = destroy_alone<&Fluid::destroy_drain>}};
  static const Part part = {.name = "fluid", .functions = {}, .world = kWorld, .classes = classes, .yaml = kYaml};
  return part;
}

}  // namespace feder::lua
