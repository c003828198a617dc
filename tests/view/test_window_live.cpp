// The running scene: the same as headless, exact about its past, unmoved by broken files.
#include "feder/net.h"
#include "feder/rigid.h"
#include "live.h"

using namespace feder;
using view::LiveScene;
using view::ReloadMode;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

double height(LiveScene& live, const char* name) {
  const ObjectId id = live.world().objects().find(name);
  REQUIRE(id);
  return live.world().find<Rigid>()->pose(id).position[1];
}

void wait_for_reload(LiveScene& live, const std::function<bool()>& done) {
  const double start = test::now();
  while (!done() && test::now() - start < 3) {
    live.tick(0, test::now());
    usleep(2000);
  }
  REQUIRE(done());
}

}  // namespace

TEST_CASE("the viewer's run is the headless run", "[view][live]") {
  const char* scene = GENERATE("rigid/tower.lua", "rigid/mixed_pile.lua", "springs/jelly.lua", "events/wake_sleep.lua");
  CAPTURE(scene);
  const std::filesystem::path file = std::string(FEDER_SOURCE_DIR "/scenes/") + scene;
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  test::run_to(live, 60);
  CHECK(live.world().hash() == test::plain_hash(file, 60));
}

TEST_CASE("looking at the past changes nothing", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t step = 0; step <= 100; ++step) {
    test::run_to(live, step);
    hashes.push_back(live.world().hash());
  }
  // every step back shows that very moment
  for (std::uint64_t step = 100; step-- > 60;) {
    live.step_back();
    REQUIRE(live.shown_step() == step);
    REQUIRE(live.world().hash() == hashes[step]);
  }
  for (std::uint64_t step = 61; step <= 70; ++step) {
    live.step_forward();
    REQUIRE(live.world().hash() == hashes[step]);
  }
  live.scrub(3);
  CHECK(live.world().hash() == hashes[3]);
  CHECK(live.in_past());
  // playing shows the recording, then goes on
  test::run_to(live, 130);
  CHECK_FALSE(live.in_past());
  CHECK(live.world().hash() == test::plain_hash(file, 130));
  CHECK(live.notice() == "");
}

TEST_CASE("who acts in the past lives the scene again, Lua's memory too", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  const auto push = [](lua::Script& s) {
    World& w = *s.world();
    w.find<Rigid>()->apply_impulse(w.objects().find("crate2"), Vec3(500, 0, 0), nullptr);
  };
  // once with the deeds as they come
  LiveScene straight(test::live_options());
  REQUIRE(straight.open(file));
  test::run_to(straight, 20);
  straight.act(push, "push");
  test::run_to(straight, 70);
  straight.run_text("world:find('crate1'):set_velocity(0, 8, 0)", {});
  test::run_to(straight, 150);

  // and once with a detour: further on, back, and then the same deed
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  test::run_to(live, 20);
  live.act(push, "push");
  test::run_to(live, 110);
  live.act(push, "a deed that will not have been");
  test::run_to(live, 120);
  live.scrub(70);
  REQUIRE(live.shown_step() == 70);
  std::string said;
  live.run_text("world:find('crate1'):set_velocity(0, 8, 0)", [&](const std::string& text, bool) { said += text; });
  CHECK(live.rewriting());
  test::run_to(live, 150);
  CHECK(live.world().hash() == straight.world().hash());
  CHECK(live.notice() == "");
  CHECK(said == "body \"crate1\"");
  CHECK(live.world().hash() != test::plain_hash(file, 150));
}

TEST_CASE("a file that differs when the past is lived again is noticed", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  view::LiveOptions options = test::live_options();
  options.poll_files = true;
  LiveScene live(options);
  REQUIRE(live.open(file));
  test::run_to(live, 40);
  live.scrub(30);
  folder.write("busy.lua", replaced(test::kBusyScene, "5 + thrown", "9 + thrown"));
  live.run_text("1", {});
  while (live.catching_up()) live.tick(0, 0);  // a clock that stands: the save is not noticed
  CHECK_THAT(live.notice(), Catch::Contains("came out differently"));
}

TEST_CASE("saving restarts at the same time, or from the start, or keeps the objects", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  live.set_param("count", "5");
  test::run_to(live, 90);
  live.set_paused(true);
  const double before = height(live, "crate5");
  const std::string changed = replaced(test::kBusyScene, "shape = feder.sphere(0.2)", "shape = feder.sphere(0.3)");

  SECTION("restart, the time is kept") {
    folder.write("busy.lua", changed);
    wait_for_reload(live, [&] { return live.reloads() == 1 && !live.catching_up(); });
    CHECK(live.world_step() == 90);
    CHECK(live.reload_seconds() < 0.3);
    CHECK(live.user_params().at("count") == "5");
    CHECK(live.world().objects().find("crate5"));
  }
  SECTION("from the start") {
    live.set_reload_mode(ReloadMode::from_start);
    folder.write("busy.lua", changed);
    wait_for_reload(live, [&] { return live.reloads() == 1; });
    CHECK(live.world_step() == 0);
  }
  SECTION("keep") {
    live.set_reload_mode(ReloadMode::keep);
    // one crate is moved in the file, and all get another density
    folder.write("busy.lua", replaced(replaced(test::kBusyScene, "position = { 0, i * 1.2, 0 }",
                                               "position = { 0, i == 2 and 7 or i * 1.2, 0 }, density = 77"),
                                      "{ 3.5, 3, 0 }", "{ 3.5, 3, 0 }"));
    const Vec3 tip = live.world().find<Springs>()->point(live.world().objects().find("rope"), 2);
    wait_for_reload(live, [&] { return live.reloads() == 1; });
    CHECK(height(live, "crate5") == before);
    CHECK(height(live, "crate2") == 7);
    CHECK(live.world().find<Rigid>()->mass(live.world().objects().find("crate5")) == Approx(77));
    CHECK(live.world().find<Springs>()->point(live.world().objects().find("rope"), 2) == tip);
    CHECK(live.shown_time() == Approx(1.5));
    test::run_to(live, 60);
    CHECK(live.world().is_finite());
  }
}

TEST_CASE("a broken file changes nothing but the message", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  test::run_to(live, 30);
  const std::string broken =
      GENERATE(as<std::string>(), "local feder = require 'feder'\nreturn feder.scene { build = = }",
               "local feder = require 'feder'\nreturn feder.scene { build = function() error('no') end }",
               "local feder = require 'feder'\nlocal world = feder.world{}\nworld:step(3)", "while true do\nend", "");
  CAPTURE(broken);
  folder.write("busy.lua", broken);
  wait_for_reload(live, [&] { return !live.error().empty(); });
  CHECK_THAT(live.error(), Catch::Contains("busy.lua"));
  CHECK(live.reloads() == 0);
  test::run_to(live, 60);
  folder.write("busy.lua", std::string(test::kBusyScene) + "\n");
  wait_for_reload(live, [&] { return live.reloads() == 1; });
  CHECK(live.error() == "");
  while (live.catching_up()) live.tick(0, test::now());
  CHECK(live.world().hash() == test::plain_hash(file, 60));
}

TEST_CASE("a file that the scene requires is watched", "[view][live]") {
  const test::SceneFolder folder;
  folder.write("part.lua", "return { height = 3 }");
  const auto file = folder.write("main.lua", R"(local feder = require "feder"
local part = require "part"
return feder.scene { build = function(world)
  world:body { name = "ball", shape = feder.sphere(1), position = { 0, part.height, 0 } } end })");
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  folder.write("part.lua", "return { height = 8 }");
  wait_for_reload(live, [&] { return live.reloads() == 1; });
  CHECK(height(live, "ball") == 8);
  folder.write("part.lua", "return { height = }");
  wait_for_reload(live, [&] { return !live.error().empty(); });
  CHECK_THAT(live.error(), Catch::Contains("part.lua:1:"));
  folder.write("part.lua", "return { height = 9 }");
  wait_for_reload(live, [&] { return live.reloads() == 2; });
  CHECK(height(live, "ball") == 9);
}

TEST_CASE("an endless loop in a handler stops the run, not the viewer", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("loop.lua", R"(local feder = require "feder"
return feder.scene { build = function(world)
  world:body { shape = feder.sphere(1) }
  world:after(0.1, function() while true do end end)
end })");
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  const double start = test::now();
  for (int i = 0; i < 30 && !live.paused(); ++i) live.tick(1.0 / 60, test::now());
  CHECK(test::now() - start < 10);
  CHECK(live.paused());
  REQUIRE(live.script().handler_errors().size() == 1);
  CHECK_THAT(live.script().handler_errors()[0].message, Catch::Contains("instruction limit"));
  REQUIRE_FALSE(live.history().marks().empty());
  CHECK(live.history().marks().back().kind == "error");
}

TEST_CASE("a parameter's value outlives the file that refuses it", "[view][live]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  LiveScene live(test::live_options());
  REQUIRE(live.open(file));
  live.set_param("count", "9");
  CHECK(live.world().objects().find("crate9"));
  live.set_param("count", "99");
  CHECK_THAT(live.error(), Catch::Contains("from 1 to 10"));
  CHECK(live.world().objects().find("crate9"));
  live.set_param("count", "8");
  CHECK(live.error() == "");
  // the new file knows a smaller range: it is loaded, with its own value
  folder.write("busy.lua", replaced(test::kBusyScene, "max = 10", "max = 4"));
  wait_for_reload(live, [&] { return live.reloads() == 1; });
  CHECK_FALSE(live.world().objects().find("crate4"));
  CHECK_THAT(live.notice(), Catch::Contains("count=8"));
}
