// What a viewer asks of a running script: plots, the files it read, a console.
#include <filesystem>
#include <fstream>

#include "support/script.h"

using namespace feder;

namespace {

const char* const kScene = R"(local feder = require "feder"
return feder.scene { build = function(world, scene)
  scene.ball = world:body { name = "ball", shape = feder.sphere(1), position = { 0, 5, 0 } }
end, update = function(world, scene)
  local _, y = scene.ball:position()
  feder.plot("height", y)
end })";

std::string error_in(lua::Script& script, const char* text) {
  try {
    script.run_string(text);
  } catch (const lua::ScriptError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("feder.plot keeps the last values with their times", "[lua][live]") {
  lua::Script script({});
  script.load_string(kScene, "test.lua");
  script.build();
  for (int i = 0; i < 1500; ++i) script.step();
  REQUIRE(script.plots().size() == 1);
  const lua::PlotSeries& plot = script.plots()[0];
  CHECK(plot.name == "height");
  CHECK(plot.points.size() == 1200);
  CHECK(plot.points.back().time == Approx(1500.0 / 60));
  CHECK(plot.points.front().time == Approx(301.0 / 60));
  CHECK(std::stod(script.run_string("select(2, scene.ball:position())")) == Approx(plot.points.back().value));
  using test::error_of;
  CHECK_THAT(error_of("feder.plot(3, 1)"), Catch::Contains("feder.plot: name"));
  CHECK_THAT(error_of("feder.plot('x', 0/0)"), Catch::Contains("feder.plot(\"x\")"));
  CHECK_THAT(error_of("for i = 1, 99 do feder.plot('x' .. i, 0) end"), Catch::Contains("at most 64"));
}

TEST_CASE("the console runs in the scene and keeps its names", "[lua][live]") {
  lua::HostOptions options;
  options.instruction_limit = 1000000;
  lua::Script script(options);
  script.load_string(kScene, "test.lua");
  script.build();
  CHECK(script.run_string("1 + 1, 'two'") == "2\ttwo");
  CHECK(script.run_string("x = 7") == "");
  CHECK(script.run_string("x") == "7");
  CHECK(script.run_string("scene.ball:name()") == "ball");
  CHECK(script.run_string("scene.ball:set_position(0, 9, 0)") == "body \"ball\"");
  CHECK(script.run_string("world:find('ball'):position()") == "0.0\t9.0\t0.0");
  CHECK_THAT(error_in(script, "world:step()"), Catch::Contains("console:1:"));
  CHECK_THAT(error_in(script, "x = = 2"), Catch::Contains("console:1:"));
  CHECK_THAT(error_in(script, "while true do end"), Catch::Contains("instruction limit"));
  CHECK_THAT(error_in(script, "pcall(function() while true do end end)"), Catch::Contains("instruction limit"));
  CHECK(script.run_string("x") == "7");
  script.step();
  CHECK(script.handler_errors().empty());
}

TEST_CASE("a script lists the files it read, the broken one too", "[lua][live]") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / "feder_test_files";
  fs::create_directories(folder);
  const auto write = [&](const char* name, const char* text) { std::ofstream(folder / name) << text; };
  write("part.lua", "return { size = = 1 }");
  write("main.lua", "local feder = require 'feder'\nlocal part = require 'part'\n");
  lua::Script script({});
  CHECK_THROWS_AS(script.load_file(folder / "main.lua"), lua::ScriptError);
  REQUIRE(script.files().size() == 2);
  CHECK(script.files()[0] == folder / "main.lua");
  CHECK(script.files()[1] == folder / "part.lua");
  fs::remove_all(folder);
}
