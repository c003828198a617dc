// feder run, explain, bench, check, new: what they print and how they end.
#include <algorithm>
#include <sstream>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

TEST_CASE("usage errors end with status 2 and one line", "[cli]") {
  const Program p;
  const Outcome unknown = p.run("rnu x.lua");
  CHECK(unknown.status == 2);
  CHECK(count_lines(unknown.err) == 1);
  for (const char* name : {"run", "test", "explain", "bench", "check", "new", "scenes"})
    CHECK(unknown.err.find(name) != std::string::npos);
  CHECK(p.run("").status == 2);
  CHECK(p.run("run").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --no-such-option").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --seconds soon").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --dt 1/0").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --set height").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --seed -1").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --record").status == 2);
  CHECK(p.run("run $S/rigid/tower.lua --export x").status == 2);
  CHECK(p.run("test --tap --json $S").status == 2);
  CHECK(p.run("--help").status == 0);
  CHECK(p.run("run --help").status == 0);
  CHECK(p.run("run --help").out.find("not in this version") == std::string::npos);
}

TEST_CASE("the version names what was built, and what of it runs here", "[cli]") {
  const Program p;
  const Outcome o = p.run("--version");
  CHECK(o.status == 0);
  CHECK(o.out.starts_with("feder "));
  CHECK(o.out.find("(float)\n") != std::string::npos);
  std::string commit = read_file(FEDER_BINARY_DIR "/bindings/report/commit.inc");
  std::erase_if(commit, [](char c) { return c == '"' || c == '\n'; });
  CHECK(o.out.find("  commit    " + (commit.empty() ? "unknown" : commit) + "\n") != std::string::npos);
  for (const char* word : {"  compiler  ", " -O", "  simd      "}) CHECK(o.out.find(word) != std::string::npos);
  const bool wide = read_file("/proc/cpuinfo").find(" avx2 ") != std::string::npos;
  CHECK(o.out.find(wide ? "simd      avx2\n" : "simd      plain\n") != std::string::npos);
}

TEST_CASE("standard output that cannot be written is a failure of every command", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  for (const std::string arguments :
       {"--version", "--help", "run ball.lua", "run ball.lua --json", "test ball.lua", "explain ball.lua",
        "bench ball.lua --runs 1 --steps 2", "check ball.lua", "new fresh", "scenes rigid"}) {
    const Outcome o = p.shell("('" FEDER_BINARY_DIR "/feder' " + arguments + " >/dev/full)");
    CAPTURE(arguments, o.err);
    CHECK(o.status == 1);
    CHECK(o.err.find("cannot be written") + o.err.find("cannot write") != 2 * std::string::npos);
    CHECK(count_lines(o.err) == 1);
  }
}

TEST_CASE("every broad phase gives the same run", "[cli]") {
  const Program p;
  const std::string scene = GENERATE("$S/mixed/everything.lua", "$S/rigid/planar_stack.lua");
  const std::string run = "run " + scene + " --no-cache --json --steps 40 --world broad_phase=";
  const Outcome wrong = p.run(run + "none");
  const std::size_t from = wrong.err.find("known: ");
  REQUIRE(from != std::string::npos);
  std::istringstream known(wrong.err.substr(from + 7));
  std::string name, hash;
  std::size_t count = 0;
  for (; known >> name; ++count) {
    if (name.back() == ',') name.pop_back();
    CAPTURE(scene, name);
    const Outcome o = p.run(run + name);
    REQUIRE(o.status == 0);
    if (count == 0) hash = o.json()["hash"];
    CHECK(o.json()["hash"] == hash);
  }
  CHECK(count > 1);
}

TEST_CASE("scenes lists the examples with titles and systems", "[cli]") {
  const Program p;
  const Outcome o = p.run("scenes --json");
  REQUIRE(o.status == 0);
  bool found = false;
  for (const auto& s : o.json()) {
    CHECK(std::filesystem::exists(s["scene"].get<std::string>()));
    if (!s["scene"].get<std::string>().ends_with("scenes/mixed/trampoline.lua")) continue;
    found = true;
    CHECK(s["title"] == "Trampoline");
    CHECK(s["systems"] == nlohmann::json{"collide", "springs", "rigid", "cloth"});
  }
  CHECK(found);
  CHECK(o.json().size() > 40);
  const Outcome some = p.run("scenes fluid");
  CHECK(some.status == 0);
  CHECK(some.out.find("Glass of water") != std::string::npos);
  CHECK(some.out.find("Tower") == std::string::npos);
  CHECK(p.run("scenes no-such-thing").status == 5);
  CHECK(p.shell("(cd '" FEDER_SOURCE_DIR "' && '" FEDER_BINARY_DIR "/feder' scenes glass)")
            .out.find("\nscenes/fluid/glass.lua ") != std::string::npos);
}

TEST_CASE("run prints a summary, or one JSON value with the promised keys", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(std::string("print('hello')\n") + kBall));
  const Outcome text = p.run("run ball.lua");
  CHECK(text.status == 0);
  CHECK(text.err.empty());
  CHECK(text.out.find("hello\n") != std::string::npos);
  CHECK(text.out.find("Probe") != std::string::npos);

  const Outcome json = p.run("run ball.lua --json --seconds 0.25 --dt 1/240 --seed 7 --threads 2");
  REQUIRE(json.status == 0);
  const auto j = json.json();
  for (const char* key : {"title", "seconds", "steps", "ms_per_step", "bodies", "points", "particles", "hash", "energy",
                          "finite", "warnings", "handler_errors"})
    CHECK(j.contains(key));
  CHECK(j["title"] == "Probe");
  CHECK(j["steps"] == 60);
  CHECK(j["seconds"].get<double>() == Approx(0.25));
  CHECK(j["bodies"] == 1);
  CHECK(j["threads"] == 2);
  CHECK(j["finite"] == true);
  CHECK(j["hash"].get<std::string>().size() == 16);
  CHECK(j["energy"]["kinetic"].get<double>() > 0);
  CHECK(j["warnings"].is_array());
  // what the script printed is not in the JSON value
  CHECK(json.err.find("hello") != std::string::npos);

  CHECK(p.run("run ball.lua --quiet --seconds 0.1").out == "hello\n");
  CHECK(p.run("run ball.lua --json").json()["steps"] == 30);
}

TEST_CASE("the same run gives the same hash, another seed or step another one", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  const auto hash = [&](const std::string& more) {
    return p.run("run ball.lua --json " + more).json()["hash"].get<std::string>();
  };
  CHECK(hash("") == hash(""));
  CHECK(hash("") == hash("--threads 4"));
  CHECK(hash("") != hash("--world dt=1/120"));
  CHECK(hash("--dt 1/120") == hash("--world dt=1/120"));
}

TEST_CASE("a scene in YAML is the scene in Lua", "[cli]") {
  const Program p;
  for (const char* more : {"", " --set height=3"}) {
    const auto yaml = p.run(std::string("run $S/yaml/tower.yaml --json --seconds 2") + more).json();
    const auto lua = p.run(std::string("run $S/rigid/tower.lua --json --seconds 2") + more).json();
    CHECK(yaml["bodies"] == lua["bodies"]);
    CHECK(yaml["hash"] == lua["hash"]);
  }
  p.write("bad.yaml", "title: x\nbodies:\n  - shape: { box: [1, 1, 1] }\n    densty: 500\n");
  const Outcome bad = p.run("run bad.yaml");
  CAPTURE(bad.err);
  CHECK(bad.status != 0);
  CHECK(count_lines(bad.err) == 1);
  CHECK(bad.err.find("bad.yaml:") == 0);
  CHECK(bad.err.find("density") != std::string::npos);
}

TEST_CASE("--set reaches feder.param", "[cli]") {
  const Program p;
  p.write("many.lua",
          "local feder = require 'feder'\nlocal n = feder.param('n', 2, { min = 1, max = 9 })\nreturn feder.scene { "
          "seconds = 0.1, "
          "build = function(world) for i = 1, n do world:body { shape = feder.sphere(0.1), position = { i, 0, 0 } } "
          "end end }\n");
  CHECK(p.run("run many.lua --json").json()["bodies"] == 2);
  CHECK(p.run("run many.lua --json --set n=5").json()["bodies"] == 5);
  CHECK(p.run("run many.lua --set n=10").status != 0);
  CHECK(p.run("run many.lua --set m=3").status != 0);
}

TEST_CASE("run --check runs the check", "[cli]") {
  const Program p;
  p.write("good.lua", scene(kBall));
  p.write("bad.lua", scene(kBall, "expect(true)\nexpect(false, 'it must not be')"));
  CHECK(p.run("run good.lua --check").status == 0);
  const Outcome bad = p.run("run bad.lua --check");
  CHECK(bad.status == 1);
  CHECK(bad.err == "bad.lua:9: it must not be\n");
  const auto j = p.run("run bad.lua --check --json").json();
  CHECK(j["check"]["passed"] == 1);
  CHECK(j["check"]["failed"] == 1);
  CHECK(p.run("run bad.lua").status == 0);
}

TEST_CASE("plain scripts run from top to bottom", "[cli]") {
  const Program p;
  p.write("plain.lua",
          "local feder = require 'feder'\nlocal world = feder.world { dt = 1 / 100 }\n"
          "world:body { shape = feder.sphere(1), position = { 0, 1, 0 } }\nworld:step(50)\nprint(world:time())\n");
  const Outcome good = p.run("run plain.lua --json");
  CHECK(good.status == 0);
  CHECK(good.json()["steps"] == 50);
  CHECK(good.json()["bodies"] == 1);
  p.write("broken.lua", "local feder = require 'feder'\nlocal world = feder.world {}\nerror('enough')\n");
  const Outcome bad = p.run("run broken.lua");
  CHECK(bad.status == 1);
  CHECK(bad.err == "broken.lua:3: enough\n");
}

TEST_CASE("explain lists what is used and names the rest", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  const Outcome json = p.run("explain ball.lua --json");
  REQUIRE(json.status == 0);
  const auto j = json.json();
  std::vector<std::string> names;
  for (const auto& s : j["systems"]) {
    names.push_back(s["name"]);
    CHECK(s["bytes"].is_number());
    CHECK(s["count"].is_number());
  }
  CHECK(std::count(names.begin(), names.end(), "rigid") == 1);
  CHECK(std::count(names.begin(), names.end(), "springs") == 0);
  CHECK(std::count(j["absent"].begin(), j["absent"].end(), "springs") == 1);
  CHECK(std::count(j["absent"].begin(), j["absent"].end(), "rigid") == 0);
  double share = 0, passes = 0;
  for (const auto& row : j["plan"]) {
    for (const char* key : {"path", "kind", "system", "name", "ms", "share"}) CHECK(row.contains(key));
    CHECK(row["system"] != "springs");
    if (row["path"] == "step") share += row["share"].get<double>();
    if (row["kind"] == "pass") passes += row["share"].get<double>();
  }
  CHECK(share == Approx(1));
  CHECK(passes > 0.5);  // the rest are the loops themselves
  CHECK(passes < 1.0001);
  const Outcome text = p.run("explain ball.lua");
  CHECK(text.status == 0);
  CHECK(text.out.find("rigid") != std::string::npos);
}

TEST_CASE("explain tells how meshes find their triangles", "[cli]") {
  const Program p;
  p.write("land.lua", scene("local land = feder.mesh({ {0,0,0}, {5,0,0}, {0,0,5} }, { {1,3,2} }, "
                            "{ volume = 'obb', build = 'sah' }) "
                            "for i = 1, 2 do world:body { name = 'land', type = 'static', shape = land } end "));
  const auto j = p.run("explain land.lua --json").json();
  std::vector<std::string> notes;
  for (const auto& s : j["systems"])
    if (s["name"] == "collide") notes = s["notes"].get<std::vector<std::string>>();
  REQUIRE(notes.size() == 1);  // one shape of two bodies
  CHECK(notes[0].find("body \"land\": mesh: bvh of obb, sah, 1 triangle") == 0);
  CHECK(p.run("explain land.lua").out.find("collide: body \"land\": mesh: bvh") != std::string::npos);
}

TEST_CASE("bench reports minimum, median and maximum, and compares", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  const Outcome first = p.run("bench ball.lua --runs 3 --steps 20 --json");
  REQUIRE(first.status == 0);
  const auto j = first.json();
  CHECK(j["scene"] == "ball.lua");
  CHECK(j["bodies"] == 1);
  CHECK(j["threads"] == 1);
  const auto& ms = j["ms_per_step"];
  CHECK(ms["min"].get<double>() > 0);
  CHECK(ms["min"].get<double>() <= ms["median"].get<double>());
  CHECK(ms["median"].get<double>() <= ms["max"].get<double>());
  p.write("before.json", first.out);
  const auto compared = p.run("bench ball.lua --runs 1 --steps 20 --json --compare before.json").json();
  CHECK(compared["compared"]["ratio"].get<double>() > 0);
  CHECK(p.run("bench ball.lua ball.lua --runs 1 --steps 5 --json").json().size() == 2);
  CHECK(p.run("bench ball.lua --compare nothing.json").status == 2);
  p.write("odd.json", "[{\"scene\": 3}]");
  CHECK(p.run("bench ball.lua --runs 1 --steps 5 --compare odd.json").status == 2);
  const std::string text = p.run("bench ball.lua --runs 2 --steps 5 --quiet").out;
  CHECK(text.find("min ") < text.find("median "));
}

TEST_CASE("bench --fail-above fails for what is slower than before, or was not there", "[cli]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  const auto gate = [&](const std::string& before, const std::string& percent) {
    p.write("before.json", before);
    return p.run("bench ball.lua --runs 1 --steps 5 --compare before.json --fail-above " + percent);
  };
  CHECK(gate(R"({"scene": "ball.lua", "ms_per_step": {"min": 1e6, "median": 1e-9}})", "0").status == 0);
  const Outcome slow = gate(R"({"scene": "ball.lua", "ms_per_step": {"min": 1e-9, "median": 1e6}})", "50");
  CHECK(slow.status == 1);
  CHECK(slow.err.starts_with("ball.lua: "));
  CHECK(slow.err.find("slower than in before.json, more than 50 %") != std::string::npos);
  CHECK(slow.out.find("ms/step") != std::string::npos);
  CHECK(gate(R"([{"scene": "other.lua", "ms_per_step": {"min": 1}}])", "50").status == 1);
  CHECK(gate("[]", "-1").status == 2);
  CHECK(p.run("bench ball.lua --fail-above 5").status == 2);
}

TEST_CASE("new writes a scene that passes its own check, and overwrites nothing", "[cli]") {
  const Program p;
  CHECK(p.run("new first").status == 0);
  CHECK(p.run("run first.lua --check --quiet").status == 0);
  CHECK(p.run("check first.lua").status == 0);
  CHECK_THAT(p.read(".feder/feder.lua"), Catch::Contains("---@class feder.World"));
  CHECK(nlohmann::json::parse(p.read(".luarc.json"))["workspace.library"][0] == ".feder");
  const std::string before = p.read("first.lua");
  CHECK(p.run("new first").status != 0);
  CHECK(p.read("first.lua") == before);
}

TEST_CASE("check finds mistakes without running", "[cli]") {
  const Program p;
  p.write("good.lua",
          scene(std::string("-- feder.nothing and world:nothing in a comment\nprint('feder.none')\n") + kBall));
  CHECK(p.run("check good.lua").status == 0);
  CHECK(p.run("check good.lua").out.find("feder.none") == std::string::npos);
  p.write("syntax.lua", "local x = 1\nlocal y = = 2\n");
  const Outcome syntax = p.run("check syntax.lua");
  CHECK(syntax.status == 3);
  CHECK(syntax.err.find("syntax.lua:2: ") == 0);
  p.write("names.lua", scene("world:bodyy { shape = feder.sphre(1) }"));
  const Outcome names = p.run("check names.lua");
  CAPTURE(names.err);
  CHECK(names.status == 1);
  CHECK(count_lines(names.err) == 2);
  CHECK(names.err.find("names.lua:5: ") == 0);
  CHECK(names.err.find("'sphere'") != std::string::npos);
  CHECK(names.err.find("'body'") != std::string::npos);
  CHECK(p.run("check names.lua --json").json()["findings"].size() == 2);
}
