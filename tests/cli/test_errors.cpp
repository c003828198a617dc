// Mistakes in scenes: one line with file:line, what was expected and what came, exit status not 0.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

// The build body starts in line 5 of the scene.
Outcome run_with(const std::string& build, const std::string& more = "") {
  const Program p;
  p.write("probe.lua", scene(build));
  return p.run("run probe.lua " + more);
}

void expect_error(const std::string& build, const std::string& words) {
  CAPTURE(build);
  const Outcome o = run_with(build);
  CAPTURE(o.err);
  CHECK(o.status != 0);
  CHECK(count_lines(o.err) == 1);
  CHECK(o.err.find("probe.lua:5: ") == 0);
  CHECK(o.err.find(words) != std::string::npos);
}

}  // namespace

TEST_CASE("scene mistakes are one line with a place", "[cli][errors]") {
  expect_error("world:body { shape = feder.sphere(1), positon = { 0, 1, 0 } }", "position");
  expect_error("world:body { shape = feder.sphere(1), position = { 0, 0 / 0, 0 } }", "nan");
  expect_error("world:body { shape = feder.sphere(1), mass = -2 }", "-2");
  expect_error("local b = world:body { name = 'crate', shape = feder.sphere(1) } b:destroy() b:velocity()", "crate");
  expect_error("world:body { shape = feder.sphre(1) }", "sphre");
  expect_error("world:joint { type = 'hing' }", "hinge");
}

TEST_CASE("a wrong solver name lists the known ones", "[cli][errors]") {
  const Program p;
  p.write(
      "solver.lua",
      "local feder = require 'feder'\nreturn feder.scene {\n  world = { rigid = { solver = 'soft_stp' } },\n  build = "
      "function(world)\n    world:body { shape = feder.sphere(1) }\n  end,\n}\n");
  for (const char* arguments : {"run solver.lua", "run $S/rigid/tower.lua --world rigid.solver=soft_stp"}) {
    const Outcome o = p.run(arguments);
    CAPTURE(arguments, o.err);
    CHECK(o.status != 0);
    CHECK(count_lines(o.err) == 1);
    CHECK(o.err.find("soft_stp") != std::string::npos);
    CHECK(o.err.find("soft_step") != std::string::npos);
    CHECK(o.err.find("impulse") != std::string::npos);
  }
  CHECK(p.run("run solver.lua").err.find("solver.lua:") == 0);
}

TEST_CASE("an error in a handler is reported once and the run goes on", "[cli][errors]") {
  const Program p;
  p.write("handler.lua", scene(std::string(kBall) + "\nworld:every(0.05, function()\n  error('broken handler')\nend)"));
  const Outcome text = p.run("run handler.lua");
  CHECK(text.status == 1);
  CHECK(text.err == "handler.lua:7: broken handler\n");
  CHECK(text.out.find("30 steps") != std::string::npos);

  const Outcome json = p.run("run handler.lua --json");
  CHECK(json.status == 1);
  const auto j = json.json();
  CHECK(j["steps"] == 30);
  REQUIRE(j["handler_errors"].size() == 1);
  CHECK(j["handler_errors"][0]["count"].get<int>() >= 9);
  CHECK(j["handler_errors"][0]["where"] == "handler.lua:7");
}

TEST_CASE("hostile values in a handler leave the run alive", "[cli][errors]") {
  const Program p;
  p.write(
      "update.lua",
      "local feder = require 'feder'\nreturn feder.scene { seconds = 0.2, build = function(world, scene)\n  scene.b = "
      "world:body { "
      "shape = feder.sphere(1) }\nend, update = function(world, scene)\n  scene.b:set_position(0 / 0, 0, 0)\nend }\n");
  const Outcome o = p.run("run update.lua --json");
  CHECK(o.status == 1);
  CHECK(o.err.find("update.lua:5: ") == 0);
  CHECK(count_lines(o.err) == 1);
  CHECK(o.json()["finite"] == true);
  CHECK(o.json()["steps"] == 12);
}

TEST_CASE("files that cannot be loaded end with status 3", "[cli][errors]") {
  const Program p;
  CHECK(p.run("run nothing.lua").status == 3);
  CHECK(p.run("run nothing.lua").err == "nothing.lua: no such file\n");
  CHECK(p.run("run .").status == 3);
  p.write("syntax.lua", "local x = 1\nreturn feder.scene {{\n");
  const Outcome o = p.run("run syntax.lua");
  CHECK(o.status == 3);
  CHECK(o.err.find("syntax.lua:") == 0);
  CHECK(count_lines(o.err) == 1);
  p.write("scene.yaml", "title: x\nbodies:\n  - [1, 2\n");
  const Outcome yaml = p.run("run scene.yaml");
  CHECK(yaml.status == 3);
  CHECK(yaml.err.find("scene.yaml:") == 0);
  CHECK(run_with("error('built badly')").status == 3);
}
