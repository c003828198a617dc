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
  lua_getfield(L, world, "fluid");
  lua_pushvalue(L, world);
  lua_pushvalue(L, options + 1);
  lua_call(L, 2, 1);
  const int fluid = lua_gettop(L);
  for (const char* part : {"fill", "emitter", "drain"}) {
    if (lua_getfield(L, options, part) == LUA_TTABLE) {
      const int given = lua_gettop(L);
      const bool list = lua_rawlen(L, given) > 0;
      for (lua_Integer i = 1; i <= (list ? static_cast<lua_Integer>(lua_rawlen(L, given)) : 1); ++i) {
        if (list)
          lua_rawgeti(L, given, i);
        else
          lua_pushvalue(L, given);
        if (lua_type(L, -1) == LUA_TTABLE && lua_getfield(L, -1, "shape") != LUA_TNIL) {
          make_shape(L);
          lua_setfield(L, -2, "shape");
        } else {
          lua_settop(L, given + 1);
        }
        lua_getfield(L, fluid, part);
        lua_pushvalue(L, fluid);
        lua_pushvalue(L, given + 1);
        lua_call(L, 2, 0);
        lua_settop(L, given);
      }
    }
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
