// The viewer as a person meets it, on a screen of its own: editing, breaking, dragging, and the same hash as headless.
#ifdef FEDER_HAS_WINDOW
#include "screen.h"

using namespace feder;
using nlohmann::json;
using test::Screen;

namespace {

// False, with a word, where this machine has no screen to try it on.
bool can_try() {
  for (const char* name : {"Xvfb", "xdotool"})
    if (!test::has_program(name)) {
      WARN("skipped: no program '" << name << "' here (scripts/setup installs it)");
      return false;
    }
  return true;
}

// Nothing in it moves or falls asleep (which would change its colour): two pictures of it are the same.
std::string still_scene(const char* extra) {
  return std::string(R"(local feder = require "feder"
return feder.scene { title = "Still", world = { gravity = { 0, 0, 0 }, sleeping = false }, build = function(world)
  world:body { type = "static", shape = feder.plane() }
  world:body { name = "crate", shape = feder.box(1, 1, 1), position = { 0, 0.5, 0 } }
  world:body { name = "post1", type = "static", shape = feder.box(0.2, 2, 0.2), position = { -3, 1, 0 } }
  world:body { name = "post2", type = "static", shape = feder.box(0.2, 2, 0.2), position = { 3, 1, 0 } }
)") + extra +
         "\nend }\n";
}

const char* const kTurning = R"(local feder = require "feder"
return feder.scene { title = "Turning", build = function(world)
  world:body { type = "static", shape = feder.plane() }
  world:body { name = "mill", type = "kinematic", shape = feder.box(3, 0.5, 0.5), position = { 0, 2, 0 },
               angular_velocity = { 0, 0, 2 } }
end }
)";

std::string run(const std::string& command, int& status) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::string text;
  char block[512];
  while (std::size_t n = fread(block, 1, sizeof block, pipe)) text.append(block, n);
  const int closed = pclose(pipe);
  status = WIFEXITED(closed) ? WEXITSTATUS(closed) : -1;
  return text;
}

}  // namespace

TEST_CASE("without a display the viewer says so in one line", "[view][screen]") {
  int status = 0;
  const std::string said = run("env -u DISPLAY -u WAYLAND_DISPLAY '" FEDER_BINARY_DIR "/feder' view '" FEDER_SOURCE_DIR
                               "/scenes/rigid/tower.lua'",
                               status);
  CHECK(status == 1);
  CHECK_THAT(said, Catch::StartsWith("feder view: no display"));
  CHECK(std::count(said.begin(), said.end(), '\n') == 1);
}

TEST_CASE("an edited scene is on the screen at once, a broken one leaves the old one running", "[view][screen]") {
  if (!can_try()) return;
  const test::SceneFolder folder;
  const auto file = folder.write("still.lua", still_scene(""));
  Screen screen;
  screen.view(file);
  REQUIRE(screen.wait([](const json& s) { return s.value("pictures", 0) > 10; }, 120));
  const Screen::Shot before = screen.shot(), same = screen.shot();
  REQUIRE(before.rgb.size() == 800 * 600 * 3);
  CHECK(test::difference(before, same) < 0.01);

  folder.write(
      "still.lua",
      still_scene(
          "world:body { name = 'wall', type = 'static', shape = feder.box(4, 3, 0.2), position = { 0, 1.5, 1 } }"));
  REQUIRE(screen.wait([](const json& s) { return s.value("reloads", 0) == 1; }));
  CHECK(screen.status()["error"] == "");
  CHECK(screen.status()["objects"].contains("wall"));
  const double seconds = screen.status()["reload_seconds"];
  WARN("reloaded in " << seconds << " s, a picture takes " << screen.status()["frame_ms"] << " ms here");
  CHECK(seconds < 0.3);
  CHECK(screen.wait_picture([&](const Screen::Shot& now) { return test::difference(before, now) > 0.05; }));
  const Screen::Shot after = screen.shot();

  const int red_before = test::count_color(after, 240, 112, 104, 12);
  folder.write("still.lua", "local feder = require 'feder'\nreturn feder.scene { build = = 3 }\n");
  REQUIRE(screen.wait([](const json& s) { return s.value("error", "") != ""; }));
  const json broken = screen.status();
  CHECK_THAT(broken["error"].get<std::string>(), Catch::Contains("still.lua:2:"));
  CHECK(screen.wait_picture([&](const Screen::Shot& now) {  // the stripe and title of the message
    return test::count_color(now, 240, 112, 104, 12) > red_before + 100;
  }));
  CHECK(screen.wait([&](const json& s) { return s["step"] > broken["step"].get<int>() + 5; }));
  CHECK(screen.viewer_runs());

  folder.write("still.lua", still_scene(""));
  REQUIRE(screen.wait([](const json& s) { return s.value("reloads", 0) == 2 && s["error"] == ""; }));
  CHECK(screen.wait_picture([&](const Screen::Shot& now) { return test::difference(before, now) < 0.02; }));
}

TEST_CASE("the old scene still moves under the message of a broken file", "[view][screen]") {
  if (!can_try()) return;
  const test::SceneFolder folder;
  const auto file = folder.write("turning.lua", kTurning);
  Screen screen;
  screen.view(file);
  REQUIRE(screen.wait([](const json& s) { return s.value("step", 0) > 5; }));
  folder.write("turning.lua", "return {");
  REQUIRE(screen.wait([](const json& s) { return s.value("error", "") != ""; }));
  const Screen::Shot a = screen.shot();
  const int step = screen.status()["step"];
  REQUIRE(screen.wait([&](const json& s) { return s["step"] > step + 20; }));
  CHECK(test::difference(a, screen.shot()) > 0.01);
}

TEST_CASE("the mouse drags a body, keys pause and step", "[view][screen]") {
  if (!can_try()) return;
  const test::SceneFolder folder;
  const auto file = folder.write("still.lua", still_scene(""));
  Screen screen;
  screen.view(file);
  REQUIRE(screen.wait([](const json& s) { return s.value("step", 0) > 5; }));
  const json start = screen.status()["objects"]["crate"];
  const int x = start["screen"][0], y = start["screen"][1];
  const auto move = [&](int mx, int my) {
    screen.input("mousemove " + std::to_string(mx) + " " + std::to_string(my));
    usleep(300000);
  };
  move(x, y);
  screen.input("mousedown 1");
  usleep(300000);
  for (int i = 1; i <= 5; ++i) move(x + 20 * i, y - 20 * i);
  CHECK(screen.wait([](const json& s) { return s["held"] == true; }, 20));
  CHECK(screen.wait([&](const json& s) {
    return s["objects"]["crate"]["position"][1] > start["position"][1].get<double>() + 0.3 &&
           std::abs(s["objects"]["crate"]["screen"][0].get<double>() - (x + 100)) < 30;
  }));
  screen.input("mouseup 1");
  CHECK(screen.wait([](const json& s) { return s["held"] == false && s["selected"] == "body \"crate\""; }));

  // a click far from where the mouse was selects, and does not turn the camera
  const json camera = screen.status()["camera"];
  screen.input("mousemove 100 100 mousemove 700 500 click 1");
  CHECK(screen.wait([](const json& s) { return s["selected"] != "body \"crate\""; }));
  CHECK(screen.status()["camera"] == camera);

  screen.input("key space");
  REQUIRE(screen.wait([](const json& s) { return s["paused"] == true; }));
  const int step = screen.status()["step"];
  const std::string hash = screen.status()["hash"];
  screen.input("key Left");
  CHECK(screen.wait([&](const json& s) { return s["step"] == step - 1 && s["past"] == true; }));
  screen.input("key Right");
  CHECK(screen.wait([&](const json& s) { return s["step"] == step && s["hash"] == hash; }));
  screen.input("key b");
  CHECK(screen.wait([&](const json& s) { return s["objects"].contains("shot1"); }));
}

TEST_CASE("a key goes through the levels of volumes, and draws none after the last", "[view][screen]") {
  if (!can_try()) return;
  const test::SceneFolder folder;
  const auto file = folder.write("still.lua", still_scene(R"(
    local v, t = {}, {}
    for i = 1, 4 do
      v[3 * i - 2], v[3 * i - 1], v[3 * i] = { i, 1, 0 }, { i + 0.8, 1, 0 }, { i, 2, 0 }
      t[i] = { 3 * i - 2, 3 * i - 1, 3 * i }
    end
    world:body { type = "static", shape = feder.mesh(v, t, { index = "bvh", volume = "sphere", leaf = 1 }) }
  )"));
  Screen screen;
  screen.view(file);
  REQUIRE(screen.wait([](const json& s) { return s.value("pictures", 0) > 10; }, 120));
  CHECK(screen.status()["volumes"].is_null());
  const Screen::Shot before = screen.shot();
  for (const int level : {0, 1, 2}) {
    screen.input("key v");
    CHECK(screen.wait([&](const json& s) { return s["volumes"] == level; }));
    CHECK(screen.wait_picture([&](const Screen::Shot& now) { return test::difference(before, now) > 0.005; }));
  }
  screen.input("key v");
  CHECK(screen.wait([](const json& s) { return s["volumes"].is_null(); }));
  int level = 0;  // of the broad phase's tree, which has a few
  for (bool drawn = true; drawn && level < 8; ++level) {
    screen.input("key c");
    CHECK(screen.wait([&](const json& s) { return s["cells"] == level || (level > 0 && s["cells"].is_null()); }));
    drawn = !screen.status()["cells"].is_null();
  }
  CHECK(level > 1);
  CHECK(level < 8);
  CHECK(screen.wait_picture([&](const Screen::Shot& now) { return test::difference(before, now) < 0.01; }));
}

TEST_CASE("viewer and headless run end in the same state", "[view][screen]") {
  if (!can_try()) return;
  const char* scene = GENERATE("rigid/mixed_pile.lua", "springs/jelly.lua", "yaml/tower.yaml");
  CAPTURE(scene);
  Screen screen;
  const std::string file = std::string("'" FEDER_SOURCE_DIR "/scenes/") + scene + "'";
  int status = 0;
  const std::string seen = run("DISPLAY=" + screen.display() + " '" FEDER_BINARY_DIR "/feder' view " + file +
                                   " --size 400x300 --seconds 0.7 --hash",
                               status);
  CHECK(status == 0);
  const json plain = json::parse(run("'" FEDER_BINARY_DIR "/feder' run " + file + " --seconds 0.7 --json", status));
  CHECK(seen == plain["hash"].get<std::string>() + "\n");
}
#endif
