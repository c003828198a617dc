// The module "feder", the classes without a world, and the list of all functions.
#include "lua/advice.h"
#include "lua/buffer.h"
#include "lua/choices.h"
#include "lua/docs.h"
#include "lua/expect.h"
#include "lua/library.h"
#include "lua/method.h"
#include "lua/params.h"
#include "lua/plot.h"
#include "lua/sandbox.h"
#include "lua/scene.h"
#include "lua/shapes.h"
#include "lua/world_options.h"

namespace feder::lua {
namespace {

int feder_world(lua_State* L) {
  State& s = state(L);
  if (lua_isnoneornil(L, 1)) {
    lua_settop(L, 0);
    lua_newtable(L);
  }
  const WorldSettings settings = read_world_options(L, 1, function_name(L));
  WorldRecord& r = push_new_world(L, settings);
  // a scene's own world stays the host's
  if (s.is_scene && s.phase != Phase::loading) return 1;
  replace_reference(L, s.last_world_ref);
  s.last_world = r.id;
  return 1;
}

double feder_deg(lua_State* L) { return check_number(L, 1, function_name(L)) * 0.01745329251994329577; }

const char* feder_version(lua_State*) { return FEDER_VERSION; }

const Method kFederFunctions[] = {
    {"world", guard<feder_world>, "feder.world{ gravity =, dt =, substeps =, ... } -> world",
     "a world of a plain script", world_rows},
    {"scene", guard<feder_scene>,
     "feder.scene{ title =, seconds =, picture =, camera =, world =, build =, update =, check =, study = } -> scene",
     "what a scene file returns", scene_rows},
    {"param", guard<feder_param>, "feder.param(name, default, [{ min =, max =, step =, choices =, help = }]) -> value",
     "a value that --set, a viewer or a study may change", param_rows},
    {"load", guard<feder_load>, "feder.load(file) -> table",
     "a YAML file (materials.yaml) beside the scene or in the libraries"},
    {"load_mesh", guard<feder_load_mesh>, "feder.load_mesh(file, [{ weld = }]) -> table",
     "{ vertices =, triangles = } of an .obj, .gltf or .glb file beside the scene or in the libraries, as world:cloth, "
     "feder.mesh and feder.hull take them",
     load_mesh_rows},
    {"choices", guard<feder_choices>, "feder.choices(option) -> {name, ...}",
     "what an option takes in this build, by its path: \"cloth.solver\", \"joint.type\", \"world.rigid.solver\""},
    {"deg", method<feder_deg>, "feder.deg(degrees) -> radians", "angles are radians everywhere"},
    {"buffer", guard<feder_buffer>, "feder.buffer(n) -> buffer", "n numbers for bulk data; buf[i] counts from 1"},
    {"wait", guard<feder_wait>, "feder.wait(seconds)", "in a task: simulated seconds, at least one step"},
    {"wait_until", guard<feder_wait_until>, "feder.wait_until(fn)",
     "in a task: until fn() is true, asked after each step"},
    {"wait_for", guard<feder_wait_for>, "feder.wait_for(kind, [filter]) -> table",
     "in a task: until such an event, which it returns as a copy"},
    {"advise", guard<feder_advise>, "feder.advise(world) -> {{ object =, text =, ... }, ...}",
     "what systems say before a run; per net: verdict, method, limit, h, hw, frequency, decay, substeps, integrator, "
     "error, error_class, resolved_hertz: is the step stable, how large are its errors, what would do"},
    {"plot", guard<feder_plot>, "feder.plot(name, value)", "a value over simulated time; the viewer draws it"},
    {"version", method<feder_version>, "feder.version() -> string", "of feder"},
};

int unknown_function(lua_State* L) {
  const std::string owner = lua_tostring(L, lua_upvalueindex(1));
  if (lua_type(L, 2) != LUA_TSTRING) fail(L, owner + " has nothing under " + describe(L, 2));
  std::vector<std::string> known;
  for (lua_pushnil(L); lua_next(L, 1); lua_pop(L, 1))
    if (lua_type(L, -2) == LUA_TSTRING) known.emplace_back(lua_tostring(L, -2));
  std::sort(known.begin(), known.end());
  fail(L, owner + " has no '" + std::string(text_at(L, 2)) + "'" + did_you_mean(text_at(L, 2), known));
}

}  // namespace

void refuse_unknown(lua_State* L, const char* name) {
  push(L, name);
  lua_pushcclosure(L, guard<unknown_function>, 1);
  lua_setfield(L, -2, "__index");
}

void open_module(lua_State* L) {
  make_class(L, Class::shape, {shape_methods()});
  make_class(L, Class::buffer, {buffer_methods()});
  make_class(L, Class::connection, {connection_methods()});
  make_class(L, Class::task, {task_methods()});
  make_class(L, Class::event, {event_methods()});
  open_shapes(L);
  open_buffer(L);
  open_events(L);
  lua_newtable(L);
  add_methods(L, kFederFunctions, "feder.", 0);
  add_methods(L, shape_functions(), "feder.", 0);
  for (const Part* part : state(L).options.parts) add_methods(L, part->functions, "feder.", 0);
  set_field(L, "pi", 3.14159265358979323846);
  lua_newtable(L);
  refuse_unknown(L, "feder");
  lua_setmetatable(L, -2);
  lua_rawgeti(L, LUA_REGISTRYINDEX, state(L).modules_ref);
  lua_pushvalue(L, -2);
  lua_setfield(L, -2, "feder");
}

void push_module(lua_State* L) {
  lua_rawgeti(L, LUA_REGISTRYINDEX, state(L).modules_ref);
  lua_getfield(L, -1, "feder");
  lua_remove(L, -2);
}

std::vector<DocRow> docs(std::span<const Part* const> parts) {
  std::vector<DocRow> rows;
  const auto add = [&rows](const char* owner, std::span<const Method> methods) {
    for (const Method& m : methods)
      rows.push_back({owner, m.name, m.signature, m.doc, m.options ? m.options() : std::vector<OptionInfo>{}});
  };
  add("feder", kFederFunctions), add("feder", shape_functions());
  for (const Part* p : parts) add("feder", p->functions);
  add("world", world_methods());
  for (const Part* p : parts) add("world", p->world);
  add("object", object_methods());
  for (const Part* p : parts)
    for (const ObjectClass& c : p->classes) add(c.name, c.methods);
  add("force", force_methods()), add("shape", shape_methods()), add("buffer", buffer_methods());
  add("expect", expect_methods()), add("expect", object_expectations());
  add("expect", place_expectations()), add("expect", world_expectations());
  add("connection", connection_methods()), add("task", task_methods()), add("event", event_methods());
  return rows;
}

std::vector<OptionInfo> system_options(Catalog systems, std::string_view system) {
  const auto read = [&](const std::string& solver) {
    WorldDesc desc;
    Params& options = desc.systems[std::string(system)];
    if (!solver.empty()) options.set("solver", solver);
    World probe(desc, systems);
    probe.need_system(system);
    return probe.desc().systems.at(std::string(system)).rows();
  };
  const auto known = [](const std::vector<OptionInfo>& rows, const char* name) {
    return std::find_if(rows.begin(), rows.end(),
                        [&](const OptionInfo& o) { return std::string_view(o.row.name) == name; });
  };
  std::vector<OptionInfo> all = read("");
  const auto solver = known(all, "solver");
  if (solver == all.end()) return all;
  // what not every variant reads is that variant's
  std::vector<std::vector<OptionInfo>> each;
  const std::string names = solver->choices;
  for (std::string_view name : split_choices(names)) each.push_back(read(std::string(name)));
  std::vector<OptionInfo> shared;
  for (const OptionInfo& o : all)
    if (std::all_of(each.begin(), each.end(), [&](const auto& rows) { return known(rows, o.row.name) != rows.end(); }))
      shared.push_back(o);
  std::vector<OptionInfo> out = shared;
  for (std::size_t k = 0; k < each.size(); ++k)
    for (OptionInfo& o : each[k]) {
      if (known(shared, o.row.name) != shared.end()) continue;
      o.of = std::string(split_choices(names)[k]);
      out.push_back(o);
    }
  return out;
}

}  // namespace feder::lua
