// What the viewer writes for other programs against its schemas: the file of --status, and --json at the end.
#ifdef FEDER_HAS_WINDOW
#include "screen.h"
#include "support/json_schema.h"

using namespace feder;
using nlohmann::json;
using test::Screen;

namespace {

json schema(const test::SceneFolder& folder, const std::string& output) {
  const std::string out = folder / "schemas";
  REQUIRE(std::system(("'" FEDER_BINARY_DIR "/feder' doc --quiet --schemas '" + out + "'").c_str()) == 0);
  std::ifstream in(out + "/" + output + ".schema.json");
  return json::parse(in);
}

}  // namespace

TEST_CASE("the status of the viewer is as its schema says, and so is what it prints", "[view][screen][status]") {
  if (!test::has_program("Xvfb")) {
    WARN("skipped: no program 'Xvfb' here (scripts/setup installs it)");
    return;
  }
  const test::SceneFolder folder;
  const auto file = folder.write("ball.lua", R"(local feder = require "feder"
feder.param("size", 1, { min = 0.5, max = 2 })
return feder.scene { title = "Ball", build = function(world)
  world:body { name = "ball", shape = feder.sphere(1), position = { 0, 2, 0 } }
  world:on("step", function() error("no") end)
end }
)");
  Screen screen;
  screen.view(file, {"--set", "size=2"});
  REQUIRE(screen.wait([](const json& s) { return s.value("step", 0) > 5 && !s["handler_errors"].empty(); }, 120));
  const json now = screen.status(), all = schema(folder, "view_status");
  CHECK(test::validate(now, all) == std::vector<std::string>{});
  CHECK(now["params"] == json({{"size", "2"}}));
  // every field of the schema is there once a scene is
  for (const auto& [name, field] : all["properties"].items()) {
    CAPTURE(name);
    CHECK(now.contains(name));
  }
  CHECK(now["objects"].contains("ball"));
  for (const char* mistake : {"title", "camera", "objects"}) {
    json doctored = now;
    doctored[mistake] = 3;
    CHECK(test::validate(doctored, all).size() == 1);
  }
  // without a scene
  folder.write("ball.lua", "return {");
  const auto broken = folder.write("broken.lua", "return {");
  screen.view(broken);
  REQUIRE(screen.wait([](const json& s) { return s.value("error", "") != ""; }, 120));
  CHECK(test::validate(screen.status(), all) == std::vector<std::string>{});

  folder.write("still.lua", "local feder = require 'feder'\nreturn feder.scene { build = function() end }\n");
  const std::string command = "DISPLAY=" + screen.display() + " '" FEDER_BINARY_DIR "/feder' view '" +
                              (folder / "still.lua").string() + "' --size 400x300 --seconds 0.1 --json > '" +
                              (folder / "out.json").string() + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream printed(folder / "out.json");
  CHECK(test::validate(json::parse(printed), schema(folder, "view")) == std::vector<std::string>{});
}
#endif
