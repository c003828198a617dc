// Scenes, parameters, overrides, checks, libraries and YAML tables.
#include <lua.h>

#include <filesystem>
#include <fstream>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

struct Folder {
  std::filesystem::path path;
  Folder() : path(std::filesystem::temp_directory_path() / "feder_lua_test") {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path / "lib/feder");
    std::filesystem::create_directories(path / "scene/sub");
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
};

std::string load_error(const std::string& text, lua::HostOptions options = {}) {
  lua::Script script(std::move(options));
  try {
    script.load_string("local feder = require 'feder'; " + text, "s.lua");
    if (script.is_scene()) script.build();
  } catch (const lua::ScriptError& e) {
    return e.what();
  }
  return "";
}

const char* const kScene = R"(
  local height = feder.param("height", 10, { min = 1, max = 40, help = "crates" })
  local style = feder.param("style", "plain", { choices = { "plain", "fancy" } })
  return feder.scene {
    title = "T", seconds = 2.5, world = { dt = 1 / 100, substeps = 2 },
    build = function(world, scene)
      scene.updates = 0
      scene.bodies = {}
      for i = 1, height do scene.bodies[i] = world:body{ name = style .. i, shape = feder.sphere(0.1), position = { i, 0, 0 } } end
    end,
    update = function(world, scene) scene.updates = scene.updates + 1 end,
    check = function(world, scene, expect)
      expect(#scene.bodies == height)
      expect(scene.updates == world:step_count(), "updates " .. scene.updates)
      expect(world:dt() == 0.01, "dt is " .. world:dt())
      expect(false, "this fails")
      expect(nil)
      error("the end")
    end,
  })";

}  // namespace

TEST_CASE("a scene is built, stepped and checked by the host", "[lua][scene]") {
  lua::HostOptions options;
  options.set = {{"height", "3"}, {"style", "fancy"}};
  options.world = {{"substeps", "3"}};
  lua::Script script(options);
  script.load_string(std::string("local feder = require 'feder'; ") + kScene, "s.lua");
  REQUIRE(script.is_scene());
  CHECK(script.title() == "T");
  CHECK(script.seconds() == 2.5);
  REQUIRE(script.params().size() == 2);
  CHECK(script.params()[0].name == "height");
  CHECK(script.params()[0].value == "3");
  CHECK(script.params()[0].fallback == "10");
  CHECK(script.params()[0].max == 40);
  CHECK(script.params()[1].choices.size() == 2);
  int steps = 0;
  script.on_step([&](World&) { ++steps; });
  for (int round = 0; round < 2; ++round) {  // building again starts afresh
    script.build();
    REQUIRE(script.world());
    CHECK(script.world()->desc().substeps == 3);
    CHECK(script.world()->objects().find("fancy3"));
    for (int i = 0; i < 10; ++i) script.step();
    const lua::CheckResult result = script.check();
    CHECK(result.has_check);
    CHECK(result.passed == 3);
    REQUIRE(result.failures.size() == 3);
    CHECK(result.failures[0].where == "s.lua:16");
    CHECK(result.failures[0].message == "this fails");
    CHECK(result.failures[2].message == "the end");
  }
  CHECK(steps == 20);
  CHECK(script.handler_errors().empty());
}

TEST_CASE("scene tables and parameters are checked", "[lua][scene]") {
  CHECK(load_error("return feder.scene{ buld = print }") ==
        "s.lua:1: feder.scene.build: expected a function(world, scene), got nil");
  CHECK(load_error("return feder.scene{ build = print, updat = print }") ==
        "s.lua:1: feder.scene: unknown option 'updat'; did you mean 'update'?");
  CHECK(load_error("return feder.scene{ build = print, world = { dt = -1 } }") ==
        "s.lua:1: world.dt: expected a number above 0 and at most 1, got -1");
  CHECK_THAT(load_error("return feder.scene{ build = print, world = { rigid = { solver = 'x' } } }"),
             Catch::Contains("s.lua:1: world."));
  CHECK(load_error("return 5") == "");  // a plain script may return what it likes
  CHECK(load_error("local feder = require 'feder'\nlocal s = feder.scene { build = function() end }\nreturn 5") ==
        "s.lua:2: expected the file to return the scene made here, got 5");
  CHECK_THAT(load_error("feder.scene{ build = print }"),
             Catch::Contains("s.lua:1: the file makes a scene and does not return it"));
  CHECK(load_error("return feder.scene{ build = function(w) w:step() end }") ==
        "s.lua:1: world:step: a scene does not step worlds; the host steps it (only plain scripts step)");
  CHECK(load_error("return feder.scene{ build = function(w) w:body{ shape = feder.sphere(1), positon = {} } end }") ==
        "s.lua:1: world:body: unknown option 'positon'; did you mean 'position'?");
  CHECK(load_error("return feder.scene{ build = function(w) feder.param('x', 1) end }") ==
        "s.lua:1: feder.param: parameters are declared while the file loads, not in build() or later; got 'x'");
  CHECK(load_error("feder.param('a b', 1)") ==
        "s.lua:1: feder.param: expected a name of letters, digits and _, got 'a b'");
  CHECK(load_error("feder.param('a', 5, { max = 4 })") ==
        "s.lua:1: feder.param(\"a\"): default: expected a number of at most 4, got 5");
  CHECK(load_error("feder.param('a', {})") ==
        "s.lua:1: feder.param: expected a number, a string or a boolean as default of 'a', got a table");
  CHECK(load_error("feder.param('a', 1) feder.param('a', 2)") ==
        "s.lua:1: feder.param: 'a' has been declared before, with the default 1");
  const auto with = [](const char* name, const char* value) {
    lua::HostOptions o;
    o.set = {{name, value}};
    return load_error(
        "feder.param('height', 10, { min = 1, max = 40 }) feder.param('fast', false) feder.param('style', 'a', { "
        "choices = { 'a', 'b' } })",
        o);
  };
  CHECK(with("height", "50") == "s.lua:1: --set height=50: expected a number from 1 to 40, got 50");
  CHECK(with("height", "ten") == "s.lua:1: --set height=ten: expected a number, got 'ten'");
  CHECK(with("height", "nan") == "s.lua:1: --set height=nan: expected a number, got 'nan'");
  CHECK(with("fast", "1") == "s.lua:1: --set fast=1: expected true or false, got '1'");
  CHECK(with("style", "c") == "s.lua:1: --set style=c: expected one of a, b, got 'c'");
  CHECK(with("heigth", "3") ==
        "--set heigth=3: unknown parameter 'heigth'; did you mean 'height'?; known: height, fast, style");
  CHECK(with("height", "20") == "");
}

TEST_CASE("world overrides name the option", "[lua][scene]") {
  const auto with = [](const char* key, const char* value) {
    lua::HostOptions o;
    o.world = {{key, value}};
    return load_error("return feder.scene{ build = function() end }", o);
  };
  CHECK(with("dt", "1/240") == "");
  CHECK(with("gravity", "0,-1.6,0") == "");
  CHECK(with("rigid.solver", "impulse") == "");
  CHECK(with("dt", "fast") == "--world dt=fast: expected a number");
  CHECK(with("substeps", "1.5") == "--world substeps=1.5: expected a whole number from 1 to 1000");
  CHECK_THAT(with("rigid.solver", "implse"), Catch::Contains("implse"));
  CHECK_THAT(with("rigid.solvr", "impulse"), Catch::Contains("did you mean 'solver'?"));
  CHECK(with("rigd.solver", "impulse") == "--world rigd.solver=impulse: unknown system 'rigd'");
  CHECK(with("substep", "2") == "--world substep=2: unknown option 'substep'; did you mean 'substeps'?");
  CHECK_THAT(with("dt", "5"), Catch::Contains("dt"));
}

TEST_CASE("plain scripts run from top to bottom", "[lua][scene]") {
  lua::Script script(lua::HostOptions{});
  int steps = 0;
  script.on_step([&](World&) { ++steps; });
  script.load_string("local feder = require 'feder' local w = feder.world{ seed = 4 } w:step(5)", "p.lua");
  CHECK(!script.is_scene());
  CHECK(steps == 5);
  REQUIRE(script.world());
  CHECK(script.world()->step_count() == 5);
  CHECK_THROWS_AS(script.build(), lua::ScriptError);
  CHECK(load_error("error('no')") == "s.lua:1: no");
  CHECK(load_error("error('no', 0)") == "s.lua:1: no");
  CHECK(load_error("local x = = 1") == "s.lua:1: unexpected symbol near '='");
}

TEST_CASE("require finds libraries and neighbours and cannot leave", "[lua][scene]") {
  const Folder f;
  f.write("lib/feder/build.lua", "return { name = ... }");
  f.write("lib/thing.lua", "return 'library'");
  f.write("scene/thing.lua", "return 'beside'");
  f.write("scene/helper.lua", "count = (count or 0) + 1 return { value = 3 }");
  f.write("scene/sub/deep.lua", "local up = require 'helper' return up.value");
  f.write("scene/one.lua", "return require 'two'");
  f.write("scene/two.lua", "return require 'one'");
  f.write("scene/broken.lua", "local x = = 2");
  f.write("scene/silent.lua", "silent = true");
  f.write("secret.lua", "return 'secret'");
  std::filesystem::create_symlink(f.path / "secret.lua", f.path / "scene/link.lua");
  f.write("scene/main.lua", R"(
    print(require("feder.build").name, require("thing"), require("helper").value, require("sub.deep"), count, require("silent"))
    print(require("helper") == require("helper"), require("feder") == require("feder"))
    for _, name in ipairs { "../secret", "..secret", ".secret", "secret", "link", "Helper", "helper.", "sub/deep", "/etc/passwd", "", "one", "broken", "a..b", "helper\0" } do
      print((select(2, pcall(require, name)):gsub("^[^:]*:%d+: ", "")))
    end)");
  lua::HostOptions options;
  options.library_roots = {f.path / "lib"};
  std::string output;
  options.print = [&](std::string_view text) { output += text; };
  lua::Script script(options);
  script.load_file(f.path / "scene/main.lua");
  CAPTURE(output);
  CHECK_THAT(output, Catch::Contains("feder.build\tlibrary\t3\t3\t1\ttrue\ntrue\ttrue\n"));
  CHECK(output.find("'secret'") != std::string::npos);  // named in a message only
  CHECK(output.find("require: no module 'secret'") != std::string::npos);
  CHECK(output.find("require: no module 'link'") != std::string::npos);
  CHECK(output.find("circle: one -> two -> one") != std::string::npos);
  CHECK(output.find("unexpected symbol near '='") != std::string::npos);
  CHECK_THAT(output, Catch::Contains("expected a name of lower-case words with dots between, got '../secret'"));
  CHECK_THAT(output, Catch::Contains("got '/etc/passwd'"));
}

TEST_CASE("feder.load reads through the host, under the same rule", "[lua][scene]") {
  const Folder f;
  f.write("scene/materials.yaml", "ice");
  f.write("outside.yaml", "no");
  f.write("scene/main.lua", R"(
    local feder = require "feder"
    print(feder.load("materials.yaml"))
    for _, name in ipairs { "../outside.yaml", "/etc/passwd", "none.yaml", "materials.txt" } do print(pcall(feder.load, name)) end)");
  lua::HostOptions options;
  std::string output;
  options.print = [&](std::string_view text) { output += text; };
  options.load_yaml = [](void* L, const std::string&, const std::string& text) {
    lua_pushstring(static_cast<lua_State*>(L), text.c_str());
  };
  lua::Script script(options);
  script.load_file(f.path / "scene/main.lua");
  CHECK(output.rfind("ice\nfalse\t", 0) == 0);
  CHECK_THAT(output, Catch::Contains("expected the name of a .yaml file"));
  CHECK_THAT(output, Catch::Contains("no file 'none.yaml'"));
  CHECK(output.find("no\n") == std::string::npos);
}

TEST_CASE("an exception of the host's own callback reaches the host", "[lua][scene]") {
  struct Stop {};
  lua::Script script(lua::HostOptions{});
  script.load_string("return require('feder').scene{ build = function() end }", "s.lua");
  script.build();
  script.on_step([](World&) { throw Stop{}; });
  CHECK_THROWS_AS(script.step(), Stop);
  script.on_step(nullptr);
  script.step();
  CHECK(script.world()->step_count() == 2);
}
