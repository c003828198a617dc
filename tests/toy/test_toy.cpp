// A system from outside enters by the doors of the house alone: scripts, YAML, events, snapshots, the hash, explain and
// the viewer's frame know it, and no file outside this folder names it.
#include "cli/program.h"
#include "feder/record.h"
#include "feder/rigid.h"
#include "support/catch.h"
#include "toy/parts.h"

using namespace feder;
using test::Outcome;
using test::Program;

namespace {

const char* const kScene = R"(
local feder = require "feder"
return feder.scene {
  title = "A sock", seconds = 4,
  build = function(world, scene)
    scene.sock = world:wind_sock { name = "sock", position = { 0, 2, 0 }, wind = { 5, 0, 0 }, segments = 4, lag = 0.1 }
    world:body { shape = feder.sphere(0.2), position = { 3, 1, 0 } }
    world:on("sleep", function(e) print("sleep", e.object:name(), e.object:kind()) end)
    world:on("wake", { cause = "gust" }, function(e) print("wake", e.cause) end)
    scene.sock:on("gust", function(e) print("gust", e.object:name(), e.speed, e.force) end)
    world:after(3, function() scene.sock:set_wind(0, 0, 2) end)
  end,
  check = function(world, scene, expect)
    local x, y, z = scene.sock:tip()
    expect(math.abs(z - 0.8) < 0.01 and math.abs(x) < 0.01, ("tip at %.3f, %.3f, %.3f"):format(x, y, z))
  end,
})";

const char* const kYaml = R"(
title: Two socks
seconds: 4
wind_socks:
  - { name: east, position: [0, 2, 0], wind: [3, 0, 0] }
  - { name: up, position: [1, 2, 0], wind: [0, 3, 0], segments: 2, segment: 0.5 }
check: |
  local x, y = world:find("up"):tip()
  expect(math.abs(y - 3) < 0.01 and math.abs(x - 1) < 0.05, "y = " .. y)
)";

Outcome run(const Program& p, const std::string& arguments) {
  return p.shell("'" FEDER_BINARY_DIR "/tests/toy_feder' " + arguments);
}

lua::HostOptions options(const ToyBuild& toy) { return lua::HostOptions{.parts = toy.parts, .systems = toy.systems}; }

}  // namespace

TEST_CASE("a system from outside: scene, check, events", "[toy]") {
  const Program p;
  p.write("sock.lua", kScene);
  p.write("socks.yaml", kYaml);
  const Outcome o = run(p, "run sock.lua");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 0);
  CHECK_THAT(o.out, Catch::Contains("sleep\tsock\twind_sock") && Catch::Contains("wake\tgust") &&
                        Catch::Contains("gust\tsock\t2.0\tnil"));
  CHECK_THAT(o.out, Catch::Contains("1 body, 1 wind_sock (4 segments)"));
  CHECK(run(p, "test sock.lua").status == 0);
  const Outcome yaml = run(p, "test socks.yaml");
  CAPTURE(yaml.out, yaml.err);
  CHECK(yaml.status == 0);
  // the usual program says what it does not know
  const Outcome other = p.run("run sock.lua");
  CHECK(other.status != 0);
  CHECK_THAT(other.err, Catch::Contains("sock.lua:6: a world has no method 'wind_sock'"));
}

TEST_CASE("a system from outside: mistakes are named", "[toy]") {
  const ToyBuild toy;
  const auto error = [&](const std::string& text) {
    lua::Script script(options(toy));
    try {
      script.load_string("local world = require('feder').world{}; " + text, "a.lua");
    } catch (const lua::ScriptError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(error("world:wind_sock{ segments = 0 }") ==
        "a.lua:1: world:wind_sock.segments: expected a whole number from 1 to 1000, got 0");
  CHECK_THAT(error("world:wind_sock{ wnd = {1, 0, 0} }"), Catch::Contains("did you mean 'wind'?"));
  CHECK_THAT(error("local s = world:wind_sock{}; s:destroy(); s:tip()"), Catch::Contains("was destroyed at a.lua:1"));
  CHECK_THAT(error("world:wind_sock{}:tup()"), Catch::Contains("a wind_sock has no method 'tup'; did you mean 'tip'?"));
  CHECK_THAT(error("world:force{ kind = 'drag', on = world:wind_sock{} }"),
             Catch::Contains("expected a tag, a body, a net"));
}

TEST_CASE("objects of a system that has no part are handles without methods of their own", "[toy]") {
  const ToyBuild toy;
  std::string printed;
  lua::Script script(lua::HostOptions{
      .parts = lua::parts(), .systems = toy.systems, .print = [&](std::string_view text) { printed += text; }});
  script.load_string(R"(
local feder = require "feder"
return feder.scene { build = function(world)
  world:on("sleep", function(e)
    print(e.object:kind(), e.object:name(), e.object:alive(), tostring(e.object))
    print(pcall(e.object.destroy, e.object))
  end)
end })",
                     "a.lua");
  script.build();
  WindSockDesc d;
  d.name = "sock", d.wind = vec3(0, -1, 0);
  script.world()->need<WindSocks>().add(d);
  for (int i = 0; i < 60; ++i) script.step();
  CHECK_THAT(printed, Catch::Contains("object\tsock\ttrue\tobject \"sock\""));
  CHECK_THAT(printed, Catch::Contains("false\ta.lua:6: object:destroy: this host has no part that destroys wind_sock"));
  CHECK(script.world()->is_finite());
}

TEST_CASE("a system from outside is not recorded, and a replay says so", "[toy]") {
  const ToyBuild toy;
  std::string bytes;
  {
    Recorder recorder([&](std::string_view more) { bytes += more; }, {});
    World w(WorldDesc{}, toy.systems);
    recorder.add(w);
    w.need_system("wind_socks");
    w.step();
    recorder.finish("finished");
  }
  const Recording recording(bytes);
  Replay replay(recording, 0, toy.systems);
  CHECK_THROWS_WITH(replay.step(), Catch::Contains("the system 'wind_socks' has no commands"));
}

TEST_CASE("a system from outside: snapshots, hash and absence", "[toy]") {
  const ToyBuild toy;
  lua::Script script(options(toy));
  script.load_string(kScene, "sock.lua");
  script.build();
  World& w = *script.world();
  for (int i = 0; i < 20; ++i) script.step();
  const std::string image = w.snapshot();
  std::uint64_t hash[2];
  for (std::uint64_t& h : hash) {
    for (int i = 0; i < 20; ++i) w.step();
    h = w.hash();
    w.restore(image);
    CHECK(w.hash() != h);
  }
  CHECK(hash[0] == hash[1]);
  // a world without a sock has nothing of it, and the hash of a program that does not know socks
  World with(WorldDesc{}, toy.systems), without(WorldDesc{}, catalog());
  for (World* world : {&with, &without}) {
    BodyDesc d;
    d.shape = make_sphere(Real(0.5));
    world->need<Rigid>().add_body(d);
    for (int i = 0; i < 10; ++i) world->step();
  }
  CHECK(with.hash() == without.hash());
  CHECK(with.report().size() == without.report().size());
}

TEST_CASE("a system from outside: explain and the frame", "[toy]") {
  const Program p;
  p.write("sock.lua", kScene);
  const Outcome o = run(p, "explain sock.lua --json");
  CAPTURE(o.out, o.err);
  REQUIRE(o.status == 0);
  bool listed = false, planned = false;
  const auto json = o.json();
  for (const auto& s : json["systems"])
    listed |= s["name"] == "wind_socks" && s["unit"] == "segments" && s["count"] == 4;
  for (const auto& n : json["plan"]) planned |= n["name"] == "trail" && n["path"] == "step/substep";
  CHECK(listed);
  CHECK(planned);
  const ToyBuild toy;
  lua::Script script(options(toy));
  script.load_string(kScene, "sock.lua");
  script.build();
  for (int i = 0; i < 60; ++i) script.step();
  view::Collector collector(toy.frames);
  view::Frame frame;
  collector.collect(*script.world(), nullptr, view::Toggles{}, frame);
  CHECK(frame.lines.size() == 4);
  CHECK(frame.instances.size() == 1);
}
