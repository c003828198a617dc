// Scenes as plain tables, as a YAML file gives them. The text is a Lua table here: reading YAML is tested in
// tests/yaml.
#include <lauxlib.h>
#include <lua.h>

#include <filesystem>
#include <fstream>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

lua::HostOptions reader() {
  lua::HostOptions options;
  options.load_yaml = [](void* state, const std::string& file, const std::string& text) {
    auto* L = static_cast<lua_State*>(state);
    if (luaL_loadbufferx(L, text.data(), text.size(), file.c_str(), "t") != LUA_OK)
      throw lua::ScriptError(file + ":1: bad test");
    lua_call(L, 0, 1);
  };
  return options;
}

// Loads and builds; the error, or "".
std::string build(lua::Script& script, const std::string& table) {
  const auto file = std::filesystem::temp_directory_path() / "feder_scene_test.yaml";
  std::ofstream(file) << "return {" + table + "}";
  try {
    script.load_file(file);
    script.build();
  } catch (const lua::ScriptError& e) {
    return e.what();
  }
  return "";
}

std::string error_of_table(const std::string& table) {
  lua::Script script(reader());
  return build(script, table);
}

}  // namespace

TEST_CASE("a table of bodies, joints and nets becomes a scene", "[lua][yaml]") {
  lua::HostOptions options = reader();
  options.set = {{"height", "4"}};
  lua::Script script(options);
  REQUIRE(build(script, R"(
    title = "Tower", seconds = 3, world = { dt = 0.01, substeps = 2 },
    params = { height = { value = 3, min = 1, max = 9 } },
    bodies = {
      { name = "floor", type = "static", shape = "plane" },
      { name = "crate", shape = { box = {1, 1, 1} }, position = {0, 0.5, 0}, ["repeat"] = { count = "$height", step = {0, 1, 0} } },
      { name = "ball", shape = { type = "sphere", radius = 0.5 }, position = {5, 3, 0} },
      { name = "rod", shape = { type = "capsule", radius = 0.1, height = 1 }, position = {7, 3, 0} },
      { name = "slab", shape = { type = "box", size = {2, 1, 3} }, position = {12, 3, 0} },
      { name = "pair", shape = { compound = { { shape = { box = {1, 1, 1} } }, { shape = { sphere = 1 }, position = {2, 0, 0} } } }, position = {20, 3, 0} },
    },
    joints = { { name = "link", type = "ball", a = "ball", b = "rod", anchor = {6, 3, 0} } },
    nets = { { name = "net", points = { {0, 30, 0}, {1, 30, 0} }, springs = { {1, 2} }, pins = {1} } },
    forces = { { kind = "drag", linear = 0.1 } },
    regions = { { name = "zone", box = { {0, 0, 0}, {1, 1, 1} } } })") == "");
  CHECK(script.title() == "Tower");
  CHECK(script.seconds() == 3);
  CHECK(script.params().size() == 1);
  World& w = *script.world();
  CHECK(w.desc().dt == 0.01);
  for (const char* name : {"floor", "crate1", "crate4", "ball", "rod", "slab", "pair", "link", "net", "zone"}) {
    CAPTURE(name);
    CHECK(w.objects().find(name));
  }
  CHECK(!w.objects().find("crate5"));
  for (int i = 0; i < 20; ++i) script.step();
  CHECK(w.is_finite());
  CHECK(script.handler_errors().empty());
}

TEST_CASE("mistakes in a table are named", "[lua][yaml]") {
  CHECK_THAT(error_of_table("bodis = {}"), Catch::Contains("unknown option 'bodis'; did you mean 'bodies'?"));
  CHECK_THAT(error_of_table("bodies = { { shape = { bx = {1, 1, 1} } } }"),
             Catch::Contains("shape: unknown shape 'bx'; did you mean 'box'?"));
  CHECK_THAT(error_of_table("bodies = { { shape = { box = {1, -1, 1} } } }"),
             Catch::Contains("feder.box.height: expected a number"));
  CHECK_THAT(error_of_table("bodies = { { shape = { sphere = 1 }, densty = 1 } }"),
             Catch::Contains("world:body: unknown option 'densty'; did you mean 'density'?"));
  CHECK_THAT(error_of_table("joints = { { type = 'ball', a = 'nobody' } }"),
             Catch::Contains("a: no object is called 'nobody'"));
  CHECK_THAT(error_of_table("bodies = 5"), Catch::Contains("bodies: expected a list, got 5"));
  CHECK_THAT(error_of_table("bodies = { 5 }"), Catch::Contains("bodies: expected a list of tables, got 5"));
#ifdef FEDER_HAS_FLUID
  CHECK_THAT(error_of_table("fluids = { { spacin = 1 } }"),
             Catch::Contains("unknown option 'spacin'; did you mean 'spacing'?"));
#else
  CHECK_THAT(error_of_table("fluids = { {} }"),
             Catch::Contains("world:fluid: this build leaves out the module 'fluid'"));
#endif
  CHECK_THAT(error_of_table("world = { dt = -1 }"), Catch::Contains("world.dt: expected a number above 0"));
  CHECK_THAT(error_of_table("dimension = 2"), Catch::Contains("scene: 'dimension' belongs into `world: { ... }`"));
  CHECK_THAT(error_of_table("rigid = {}"), Catch::Contains("scene: 'rigid' belongs into `world: { rigid: { ... } }`"));
  CHECK_THAT(error_of_table("params = { h = { min = 1 } }"), Catch::Contains("params.h: expected value:"));
  CHECK_THAT(error_of_table("bodies = { { shape = 'plane', ['repeat'] = { count = -1 } } }"),
             Catch::Contains("repeat.count: expected a whole number from 0"));
}
