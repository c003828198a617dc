// feder run --record, replay and diff; and every scene, edited in the middle, against its replay.
#include "cli/program.h"
#include "feder/lua.h"
#include "feder/record.h"
#include "feder/yaml.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;
namespace fs = std::filesystem;

namespace {

const std::string kRecordedScene = R"(local feder, crate = require 'feder', nil
local push = feder.param('push', 0)
return {
  title = 't', seconds = 1,
  build = function(world)
    world:body{ name = 'floor', type = 'static', shape = feder.plane() }
    crate = world:body{ name = 'crate', shape = feder.box(1, 1, 1), position = {0, 3, 0} }
  end,
  update = function(world) if world:step_count() == 20 and push ~= 0 then crate:set_velocity(push, 0, 0) end end,
}
)";

// What is done to a world in the middle of a run: objects come, go, and are set in motion.
constexpr const char* kEdit = R"(
  local flat = world:dimension() == 2
  for k, body in ipairs(world:bodies()) do
    if body:type() == "dynamic" then
      if k % 3 == 0 then body:destroy() else body:set_velocity(0.1 * k, 0.5, 0) end
    end
  end
  world:body{ name = "late", shape = flat and feder.circle(0.2) or feder.sphere(0.2), position = flat and {0.1, 4} or {0.1, 4, 0.1} }
  world:set_gravity(0.1, -9, 0)
)";

}  // namespace

TEST_CASE("every scene, with an edit in the middle, is the same in its replay at every step", "[cli][replay]") {
  constexpr int kSteps = 10;
  int scenes = 0, edited = 0;
  for (const auto& entry : fs::recursive_directory_iterator(FEDER_SOURCE_DIR "/scenes")) {
    const std::string file = entry.path().string(), kind = entry.path().extension();
    if ((kind != ".lua" && kind != ".yaml") || file.find("/extreme/") != std::string::npos) continue;
    CAPTURE(file);
    std::string bytes;
    std::vector<World*> worlds;
    std::vector<std::uint64_t> ends;
    {
      Recorder recorder([&](std::string_view more) { bytes += more; }, {});
      lua::HostOptions host;
      host.print = [](std::string_view) {};
      host.library_roots = {FEDER_SOURCE_DIR "/scripts"};
      host.load_yaml = yaml::push;
#ifdef FEDER_HAS_MESHES
      host.load_mesh = meshes::read;
#endif
      host.made = [&](World& world) { recorder.add(world), worlds.push_back(&world); };
      lua::Script script(host);
      script.load_file(file);
      if (script.is_scene()) {
        script.build();
        for (int k = 0; k < kSteps; ++k) script.step();
        script.run_string(kEdit);
        for (int k = 0; k < kSteps; ++k) script.step();
        script.run_string(kEdit);
        ++edited;
      }
      if (script.is_scene()) ends.push_back(script.world()->hash());
      recorder.finish("finished");
    }
    // the recording has the hash of each step
    const Recording recording(bytes);
    REQUIRE(recording.world_count() == worlds.size());
    for (std::size_t k = 0; k < worlds.size(); ++k) {
      Replay replay(recording, k, catalog(), 1 + scenes % 2);
      while (replay.step()) CHECK(replay.has_hash());
      CHECK(replay.same());
      if (k < ends.size()) CHECK(replay.world().hash() == ends[k]);
    }
    scenes += !worlds.empty();
  }
  CHECK(scenes > 60);
  CHECK(edited > 60);
}

TEST_CASE("run --record and replay, without the scene", "[cli][recordings]") {
  const Program p;
  p.write("scene.lua", kRecordedScene);
  const Outcome run = p.run("run scene.lua --set push=2 --record a.rec --json");
  REQUIRE(run.status == 0);
  REQUIRE(p.shell("rm scene.lua").status == 0);
  const Outcome replay = p.run("replay a.rec --json");
  CHECK(replay.status == 0);
  const auto world = replay.json()["worlds"][0];
  CHECK(world["hash"] == run.json()["hash"]);
  CHECK((world["same"] == true && world["parted"].is_null() && world["steps"] == 60));
  CHECK(p.run("replay a.rec --threads 2 --json").json()["worlds"][0]["threads"] == 2);
  CHECK(p.run("replay a.rec --steps 7 --json").json()["worlds"][0]["steps"] == 7);
  const Outcome list = p.run("replay a.rec --commands");
  CHECK(list.out.find("world 1 step 21: rigid.set_velocity body \"crate\", (2, 0, 0)\n") != std::string::npos);
  const Outcome facts = p.run("replay a.rec --facts");
  CHECK(facts.out.find("--set: push=2\n") != std::string::npos);
  CHECK(facts.out.find("scene.lua:\n" + kRecordedScene) != std::string::npos);
  CHECK(facts.status == 0);
}

TEST_CASE("a plain script's worlds are recorded, and a run that is stopped", "[cli][recordings]") {
  const Program p;
  p.write("plain.lua",
          "local feder = require 'feder' local a, b = feder.world{}, feder.world{ gravity = {0, 0, 0} }\n"
          "for _, w in ipairs{ a, b } do w:body{ shape = feder.sphere(1), velocity = {1, 0, 0} } end\n"
          "a:step(5) b:step(7) a:close() b:step(2)\n");
  REQUIRE(p.run("run plain.lua --record p.rec").status == 0);
  const auto worlds = p.run("replay p.rec --json").json()["worlds"];
  REQUIRE(worlds.size() == 2);
  CHECK((worlds[0]["steps"] == 5 && worlds[1]["steps"] == 9));
  p.write("scene.lua", kRecordedScene);
  const Outcome stopped = p.run("run scene.lua --seconds 1e6 --timeout 1 --record s.rec");
  CHECK(stopped.status == 4);
  const Outcome replay = p.run("replay s.rec --json");
  CHECK(replay.status == 0);
  CHECK(replay.json()["ended"] == "exit status 4");
  CHECK(replay.json()["worlds"][0]["steps"] > 100);
}

TEST_CASE("feder test --replay holds each run against its replay", "[cli][replay]") {
  const Program p;
  for (const char* how : {"", " --isolate"}) {
    const Outcome o = p.run(std::string("test $S/rigid/tower.lua $S/mixed/everything.lua --replay") + how);
    CHECK(o.status == 0);
    CHECK(o.out.find("2 passed, 0 failed") != std::string::npos);
  }
}

TEST_CASE("a failed test leaves its recording", "[cli][recordings]") {
  const Program p;
  std::string text = kRecordedScene;
  text.replace(text.rfind('}'), 1, "check = function(world) expect(false, 'never') end }");
  p.write("scene.lua", "local expect = require('feder').expect\n" + text);
  CHECK(p.run("test scene.lua --artifacts left").status == 1);
  const auto worlds = p.run("replay left/scene.lua.rec --json").json()["worlds"];
  CHECK((worlds[0]["same"] == true && worlds[0]["steps"] == 60));
}

TEST_CASE("what is no recording, cut off or cannot be written ends in a line", "[cli][recordings]") {
  const Program p;
  p.write("scene.lua", kRecordedScene);
  REQUIRE(p.run("run scene.lua --record a.rec").status == 0);
  REQUIRE(p.shell("(head -c 900 a.rec > cut.rec; sed 's/crate/grate/' a.rec > bad.rec)").status == 0);
  for (const auto& [arguments, status, why] :
       {std::tuple{"replay scene.lua", 3, "scene.lua: not a recording of feder"},
        std::tuple{"replay none.rec", 3, "none.rec: no such file"},
        std::tuple{"replay .", 3, ".: expected a recording, got a folder"},
        std::tuple{"replay cut.rec", 3, "cut.rec: block 4 at byte"}, std::tuple{"replay bad.rec", 3, "is damaged"},
        std::tuple{"diff a.rec cut.rec", 3, "cut.rec: block 4 at byte"},
        std::tuple{"run scene.lua --record /dev/full", 1, "/dev/full: cannot be written"},
        std::tuple{"run scene.lua --record no/such/a.rec", 1, "no/such/a.rec: cannot be written"},
        std::tuple{"run scene.lua --hash-every 2", 2, "--hash-every needs --record"}}) {
    const Outcome o = p.run(arguments);
    CAPTURE(arguments, o.err);
    CHECK(o.status == status);
    CHECK(o.err.find(why) != std::string::npos);
    CHECK(count_lines(o.err) == 1);
  }
  // what was there stays when a run fails to load
  p.write("broken.lua", "local x = nil + 1");
  const std::string before = p.read("a.rec");
  CHECK(p.run("run broken.lua --record a.rec").status != 0);
  CHECK(p.read("a.rec") == before);
}

TEST_CASE("diff names the first step, object and quantity", "[cli][recordings]") {
  const Program p;
  p.write("scene.lua", kRecordedScene);
  for (const char* words : {"--record a.rec", "--record same.rec --threads 2", "--record push.rec --set push=0.001",
                            "--record long.rec --seconds 2", "--record fine.rec --hash-every 0"})
    REQUIRE(p.run(std::string("run scene.lua ") + words).status == 0);
  const Outcome same = p.run("diff a.rec same.rec");
  CHECK((same.status == 0 && same.out == "the same: every command and every hash\n"));
  CHECK(p.run("diff a.rec fine.rec").status == 0);
  const Outcome o = p.run("diff a.rec push.rec");
  CHECK(o.status == 1);
  CHECK(o.out.find("before step 21 another thing is done:\n  first   nothing more\n  second  rigid.set_velocity body "
                   "\"crate\", (0.001") == 0);
  CHECK(o.out.find("step 21: 1 object part\n  body \"crate\": velocity.") != std::string::npos);
  const auto json = p.run("diff a.rec push.rec --json").json();
  CHECK((json["same"] == false && json["state"]["step"] == 21 && json["command"]["step"] == 21));
  CHECK((json["objects"][0]["object"] == "body \"crate\"" && json["objects"][0]["unit"] == "m/s"));
  CHECK(p.run("diff a.rec long.rec").out == "steps: 60 and 120\n");
}

TEST_CASE("diff finds a change of a parameter, and objects that only one has", "[cli][recordings]") {
  const Program p;
  const std::string make = R"(local feder = require 'feder'
    local mu, more = feder.param('mu', 0.5), feder.param('more', false)
    return { seconds = 1, build = function(world)
      world:body{ type = 'static', shape = feder.plane(), friction = mu }
      world:body{ name = 'box', shape = feder.box(1, 1, 1), position = {0, 0.5, 0}, velocity = {3, 0, 0} }
      if more then
        world:body{ name = 'extra', shape = feder.sphere(1), position = {9, 9, 9} }
      end
    end }
  )";
  p.write("scene.lua", make);
  REQUIRE(p.run("run scene.lua --record a.rec").status == 0);
  REQUIRE(p.run("run scene.lua --record b.rec --set mu=0.51").status == 0);
  REQUIRE(p.run("run scene.lua --record c.rec --set more=true").status == 0);
  const Outcome mu = p.run("diff a.rec b.rec");
  CHECK(mu.out.find("before step 1 another thing is done") == 0);
  CHECK(mu.out.find("\nstep 1: 1 object part\n  body \"box\": ") != std::string::npos);
  CHECK(p.run("diff a.rec c.rec").out.find("body \"extra\": only in the second") != std::string::npos);
}
