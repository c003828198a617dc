// feder.expect and its physics: what holds, what is reported, and that waiting steps the world as the host does.
#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

const std::string kGround = "world:body{ type = 'static', shape = feder.plane() } ";
const std::string kFalling =
    "local expect = feder.expect; local b = world:body{ name = 'b', shape = feder.box(1, 1, 1), position = {0, 2, 0} "
    "} ";

// Of a plain script: failures as they are reported.
std::vector<std::string> failures_of(const std::string& text) {
  std::vector<std::string> messages;
  const Ran ran = run(kFalling + text);
  CHECK(ran.error == "");
  for (const auto& e : ran.errors) {
    CHECK(e.expectation);
    messages.push_back(e.where + ": " + e.message);
  }
  return messages;
}

lua::CheckResult check_of(const std::string& build, const std::string& check, lua::HostOptions options = {}) {
  lua::Script script(std::move(options));
  script.load_string("local feder = require 'feder'\nreturn feder.scene { build = function(world, scene) " + build +
                         " end, check = function(world, scene, expect)\n" + check + " end }",
                     "scene.lua");
  script.build();
  script.step();
  return script.check();
}

}  // namespace

TEST_CASE("an expectation that fails does not end the script", "[lua][expect]") {
  const Ran ran = run("feder.expect(1 > 2, 'one')\nfeder.expect(true)\nfeder.expect(nil)\nprint('end')");
  CHECK(ran.error == "");
  CHECK(ran.output == "end\n");
  REQUIRE(ran.errors.size() == 2);
  CHECK(ran.errors[0].message == "one");
  CHECK(ran.errors[0].where == "test.lua:1");
  CHECK(ran.errors[1].where == "test.lua:3");
}

TEST_CASE("physics expectations hold where they should and say why not elsewhere", "[lua][expect]") {
  // each line: what is expected, and the message when it does not hold
  const struct {
    std::string text, message;
  } rows[] = {
      {kGround + "expect.settles(b, 5)", ""},
      {"expect.settles(b, 1)", "expected to settle within 1 s, got"},
      {kGround + "expect.asleep(b, 5)", ""},
      {"expect.asleep(b)", "body \"b\": expected to sleep, got it is awake"},
      {kGround + "expect.near(b, {0, 0.5, 0}, 0.01, 5)", ""},
      {"expect.near(b, {0, 2, 0}, 0)", ""},
      {"expect.near(b, {0, 1, 0}, 0.5)", "body \"b\": expected at (0, 1, 0), got (0, 2, 0), 1 m away"},
      {"expect.near(1, 1.1, 0.2)", ""},
      {"expect.near(0/0, 1, 10)", "expected 1 within 10, got nan"},
      {"expect.inside({b}, {{1, 3, 1}, {-1, 1, -1}})", ""},
      {"expect.inside(b, {{-1, 0, -1}, {1, 1, 1}})", "expected inside (-1, 0, -1) to (1, 1, 1), got (0, 2, 0)"},
      {kGround + "expect.events('contact_begin', 1, 2)", ""},
      {kGround + "expect.events('hit', {1, 9}, 2)", ""},
      {"expect.events('contact_begin', 1, 1)", "contact_begin events: expected 1 within 1 s, got 0"},
      {"expect.events('contact_begin', 0, 1)", ""},
      {"expect.energy_drift(0.02, 1)", ""},
      {kGround + "expect.energy_drift(1e-3, 2)", "energy: expected a drift of at most 0.001, got"},
      {"expect.no_warnings()", ""},
      {"expect.no_warnings('non_finite', 1) expect.near(world:time(), 1, 1e-9)", ""},
      {"expect.above(b, 1)", ""},
      {"expect.above(b, 2.5)", "body \"b\": expected above y = 2.5, got (0, 2, 0)"},
      {"expect.below(b, 1, 1)", ""},
      {"expect.below(b, 1, 0.1)", "expected below y = 1 within 0.1 s, got (0, 1."},
      {"expect.angle(b, 0, 1e-6)", ""},
      {"b:set_rotation(0.70710678, 0, 0, 0.70710678) expect.angle(b, 0.1, 0.2)",
       "expected an angle of 0.1 rad, got 1.570"},
      {kGround + "expect.contact(b, nil, 2)", ""},
      {kGround + "world:step(60) expect.contact(b, nil, {0.5, 0.8})", ""},
      {kGround + "world:step(60) expect.contact(b, b)", "expected contact with body \"b\" from 0 to 1 s, got none"},
      {kGround + "expect.contact(b, nil, {0, 0.3})", "expected contact with anything from 0 to 0.3 s, got none"},
      {kGround + "expect.no_contact(b, nil, {0, 0.3})", ""},
      {kGround + "world:step(60) expect.no_contact({b})",
       "one of 1 objects: expected no contact with anything from 0 to"},
      {kGround + "world:step(60) b:set_position(0, 9, 0) world:step(1) expect.no_contact(b, nil, {1.02, 1.1})", ""},
      {"expect.finite(0.1)", ""},
      {kGround + "expect.max_penetration(0.01, 2)", ""},
      {kGround + "expect.max_penetration(1e-9, 2)", "penetration: expected at most 1e-09 m during 2 s, got"},
      {"expect.momentum({0, 0, 0}, 1e-6)", ""},
      {"expect.momentum({0, 0, 0}, 1, 0.1)", "momentum: expected (0, 0, 0) kg m/s during 0.1 s, got (0, -163.5"},
      {"b:set_angular_velocity(0, 6, 0) expect.angular_momentum({0, 1000, 0}, 1, 0.2)", ""},
      {"expect.angular_momentum({0, 1000, 0}, 1)", "angular momentum: expected (0, 1000, 0) kg m2/s, got (0, 0, 0)"},
      {"expect.hash(world:hash())", ""},
      {"expect.hash('none')", "state: expected hash none, got "},
      {"expect.error(1, '<', 2)", ""},
      {"expect.error(3, '<', 2, 'drop')", "drop: expected < 2, got 3"},
  };
  for (const auto& row : rows) {
    const auto messages = failures_of(row.text);
    CAPTURE(row.text);
    if (row.message.empty()) {
      CHECK(messages.empty());
      continue;
    }
    REQUIRE(messages.size() == 1);
    CAPTURE(messages[0]);
    CHECK(messages[0].find(row.message) != std::string::npos);
    CHECK(messages[0].starts_with("test.lua:1: "));
  }
}

TEST_CASE("soft things are tested too", "[lua][expect]") {
  CHECK(failures_of(kGround +
                    "local cloth = world:cloth{ size = {1, 1}, resolution = {5, 5}, position = {3, 1, 0}, pins "
                    "= 'top' } expect.inside(cloth, {{-5, -1, -5}, {5, 5, 5}}) expect.settles(cloth, 30, 0.2)")
            .empty());
  const auto messages = failures_of(
      "local net = world:net{ points = { {0, 1, 0}, {1, 1, 0} }, masses = 1, springs = {} } expect.inside(net, {{-1, "
      "-1, -1}, {0.5, 2, 1}})");
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].find("point 2 at (1, 1, 0)") != std::string::npos);
}

TEST_CASE("angles of hinges, stretch, volumes and particles are tested", "[lua][expect]") {
  const std::string door =
      "b:destroy() local d = world:body{ shape = feder.box(1, 2, 0.1), angular_velocity = {0, 1, 0} } local hinge = "
      "world:joint{ type = 'hinge', a = d, axis = {0, 1, 0}, anchor = {0, 0, 0} } ";
  const std::string cloth =
      "local cloth = world:cloth{ size = {1, 1}, resolution = {5, 5}, position = {3, 5, 0}, pins = 'top' } ";
  // a closed box of 1 m, the faces outwards
  const std::string closed =
      "local v = {} for x = 0, 1 do for y = 0, 1 do for z = 0, 1 do v[#v + 1] = {x, y + 5, z} end end end local box = "
      "world:cloth{ vertices = v, triangles = { {1,2,4}, {1,4,3}, {5,7,8}, {5,8,6}, {1,5,6}, {1,6,2}, {3,4,8}, "
      "{3,8,7}, "
      "{1,3,7}, {1,7,5}, {2,6,8}, {2,8,4} } } ";
  const std::string fluid = "local fluid = world:fluid{ spacing = 0.1 } fluid:fill{ box = {{0, 0, 0}, {1, 0.5, 1}} } ";
  const struct {
    std::string text, message;
  } rows[] = {
      {door + "expect.angle(hinge, -1, 0.02, 2)", ""},
      {door + "expect.angle(hinge, 1, 0.02, 1)", "expected an angle of 1 rad within 1 s, got -"},
      {cloth + "expect.stretch(cloth, 0.2, 0.5)", ""},
      {cloth + "expect.stretch(cloth, 1e-6, 0.5)", "expected a stretch of at most 1e-06 during 0.5 s, got "},
      {closed + "expect.volume(box, 1, 1e-5)", ""},
      {closed + "expect.volume(box, 2, 0.1)", "expected a volume of 2 m3, got 1 m3"},
      {fluid + "expect.volume(fluid, 0.5, 0.01)", ""},
      {fluid + "expect.volume(fluid, 0.6, 0.01)", "expected a volume of 0.6 m3, got 0."},
      {fluid + "expect.particles_in(fluid, {{0, 0, 0}, {1, 1, 0.5}}, 250)", ""},
      {fluid + "expect.particles_in({fluid}, {{0, 0, 0}, {1, 1, 0.5}}, {1, 9})",
       "particles in (0, 0, 0) to (1, 1, 0.5): expected 1 to 9, got 250"},
      {fluid + "expect.particles_in(fluid, {{0, -9, 0}, {1, -1, 1}}, {400, 500}, 2)", ""},
  };
  for (const auto& row : rows) {
    const auto messages = failures_of(row.text);
    CAPTURE(row.text, messages);
    REQUIRE(messages.size() == (row.message.empty() ? 0u : 1u));
    if (!messages.empty()) CHECK(messages[0].find(row.message) != std::string::npos);
  }
}

TEST_CASE("what has once not been finite is not finite", "[lua][expect]") {
  const auto messages = failures_of(
      "local light = world:body{ shape = feder.sphere(0.5), density = 1e-8, position = {9, 9, 9} } for i = 1, 100 do "
      "light:apply_force(1e30, 0, 0) end expect.finite() world:step(1) expect(world:is_finite()) expect.finite()");
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].find("state: expected finite numbers, got ") != std::string::npos);
}

TEST_CASE("the same scene with other options ends in the same state, or says where they part", "[lua][expect]") {
  const auto file = std::filesystem::temp_directory_path() / "feder_same_test.lua";
  FILE* out = std::fopen(file.c_str(), "w");
  REQUIRE(out);
  std::fputs(
      "local feder = require 'feder'\nreturn feder.scene { build = function(world) world:body { type = 'static', shape "
      "= "
      "feder.plane() } for i = 1, 5 do world:body { name = 'b' .. i, shape = feder.box(1, 1, 1), position = { 0.02 * "
      "i, "
      "1.1 * i, 0 } } end end,\ncheck = function(world, scene, expect)\nexpect.same_as { threads = 2 }\nexpect.same_as "
      "{ "
      "dt = 1 / 60 }\nexpect.same_as { substeps = 5 }\nexpect(not pcall(expect.same_as, { bogus = 1 }))\nworld:body { "
      "shape = feder.sphere(1), position = { 9, 9, 9 } }\nexpect.same_as {}\nend }\n",
      out);
  std::fclose(out);
  lua::Script script({});
  script.load_file(file);
  script.build();
  for (int i = 0; i < 30; ++i) script.step();
  const lua::CheckResult result = script.check();
  std::filesystem::remove(file);
  CHECK(result.passed == 3);
  REQUIRE(result.failures.size() == 2);
  CAPTURE(result.failures[0].message, result.failures[1].message);
  CHECK(result.failures[0].message.find("as with substeps = 5, got ") != std::string::npos);
  CHECK(result.failures[0].message.find("; they part at step 1 (0.0166") != std::string::npos);
  CHECK(result.failures[0].message.find(" m off") != std::string::npos);
  CHECK(result.failures[1].message.find("; the check has changed the state") != std::string::npos);
  CHECK(error_of("feder.expect.same_as { threads = 2 }").find("only the check of a scene") != std::string::npos);
}

TEST_CASE("a failure knows the difference and the name that was called", "[lua][expect]") {
  const lua::CheckResult result = check_of(
      "", "local near = expect.near\nnear(3, 1, 0.5)\nexpect.error(3, '<', 1)\nexpect(false)\npcall(expect, false)");
  REQUIRE(result.failures.size() == 4);
  CHECK(result.failures[0].delta == "2");
  CHECK(result.failures[0].call == "near");
  CHECK(result.failures[1].delta == "2");
  CHECK(result.failures[1].call == "error");
  CHECK(result.failures[2].call == "expect");
}

TEST_CASE("a spinning ball has not settled, a warning is named", "[lua][expect]") {
  CHECK(failures_of("b:destroy() local s = world:body{ shape = feder.sphere(1), gravity_scale = 0, angular_velocity = "
                    "{0, 3, 0}, angular_damping = 0 } expect.settles(s, 1)")
            .size() == 1);
  const auto messages = failures_of(
      "local light = world:body{ shape = feder.sphere(0.5), density = 1e-8, position = {9, 9, 9} } for i = 1, 100 do "
      "light:apply_force(1e30, 0, 0) end world:step(1) expect.no_warnings()");
  REQUIRE(!messages.empty());
  CHECK(messages[0].find("warnings: expected none of 'non_finite', got") != std::string::npos);
}

TEST_CASE("mistakes in expectations are errors with the line", "[lua][expect]") {
  for (const char* text :
       {"feder.expect.settles(3)", "feder.expect.settles({})", "feder.expect.events('hot', 1)",
        "feder.expect.near(world, {0, 0, 0}, 1)", "feder.expect.error(1, '=', 2)", "feder.expect.energy_drift(-1)",
        "feder.expect.budget{ second = 1 }", "feder.expect.inside(world:body{ shape = feder.sphere(1) }, {{0, 0, 0}})",
        "feder.expect.asleep(world:body{ shape = feder.sphere(1) }, -1)", "feder.expect.contact()",
        "feder.expect.contact(world:body{ shape = feder.sphere(1) }, nil, {2, 1})", "feder.expect.no_contact({})",
        "feder.expect.stretch(world:body{ shape = feder.sphere(1) }, 1)", "feder.expect.volume(world, 1, 1)",
        "feder.expect.momentum({0, 0, 0}, -1)", "feder.expect.particles_in({}, {{0, 0, 0}, {1, 1, 1}}, 1)"}) {
    const std::string error = error_of(text);
    CAPTURE(text, error);
    CHECK(error.starts_with("test.lua:1: expect."));
  }
}

TEST_CASE("an expectation that nothing is called by is named with the nearest", "[lua][expect]") {
  CHECK(error_of("feder.expect.setles(1)") == "test.lua:1: expect has no 'setles'; did you mean 'settles'?");
}

TEST_CASE("a check waits: the host steps the world, with handlers and update", "[lua][expect]") {
  const lua::CheckResult result = check_of(
      "world:body{ type = 'static', shape = feder.plane() } scene.b = world:body{ name = 'b', shape = feder.box(1, 1, "
      "1), position = {0, 2, 0} } world:every(0.1, function() scene.ticks = (scene.ticks or 0) + 1 end)",
      "expect.settles(scene.b, 5)\nexpect(scene.ticks > 5)\nexpect(pcall(world.step, world, 1) == false)\n"
      "expect.asleep(scene.b)\n");
  CHECK(result.passed == 3);
  REQUIRE(result.failures.size() == 1);
  CHECK(result.failures[0].where == "scene.lua:6");
  CHECK(result.failures[0].object == "body \"b\"");
  CHECK(result.failures[0].time > 0.8);
  CHECK(result.failures[0].step > 40);
}

TEST_CASE("a check waits in coroutines and protected calls too, and loses what dies meanwhile", "[lua][expect]") {
  const std::string build =
      "scene.b = world:body{ name = 'b', shape = feder.box(1, 1, 1) } world:after(0.5, function() if scene.b:alive() "
      "then "
      "scene.b:destroy() end end)";
  const lua::CheckResult good = check_of(
      build,
      "expect(pcall(expect.near, scene.b, {0, 0, 0}, 1, 0.1)) coroutine.wrap(function() expect.near(scene.b, {0, "
      "0, 0}, 9, 0.2) expect.events('hit', 0, 0.1) end)() expect(world:time() > 0.1)");
  CHECK(good.failures.empty());
  CHECK(good.passed == 5);
  const lua::CheckResult lost = check_of(build, "expect.near(scene.b, {0, 9, 0}, 1, 3)");
  REQUIRE(lost.failures.size() == 1);
  CAPTURE(lost.failures[0].message);
  CHECK(lost.failures[0].message.find("expect.near: body \"b\" was destroyed at scene.lua:2") != std::string::npos);
}

TEST_CASE("handlers cannot wait, and are counted by a budget", "[lua][expect]") {
  const std::string error = error_of(
      "local b = world:body{ shape = feder.sphere(1) } world:after(0.1, function() feder.expect.settles(b, 1) end) "
      "world:step(20) error(world:step_count())");
  CHECK(error.find("20") != std::string::npos);
  const std::string busy = "world:every(1/60, function() local x = 0 for i = 1, 10000 do x = x + i end end)";
  CHECK(check_of(busy, "for i = 1, 20 do expect.events('hit', 1, 1/60) end expect.budget{ instructions = 1e6 }")
            .failures.size() == 20);
  const auto over = check_of(busy, "expect.events('hit', 0, 1)\nexpect.budget{ instructions = 1000, ms = 1e-9 }");
  REQUIRE(over.failures.size() == 1);
  CHECK(over.failures[0].message.find("scripts: expected at most 1000 instructions per step, got") == 0);
  CHECK(over.notes.size() == 1);
}

TEST_CASE("a check that waits for ever in a handler ends at the limit", "[lua][expect]") {
  lua::HostOptions options;
  options.instruction_limit = 100'000;
  const auto result =
      check_of("world:after(0.5, function() while true do end end)", "expect.events('hit', 1, 2)", options);
  CHECK(result.limit == lua::Limit::instructions);
  // each step has a budget of its own: together they may take more than one call
  CHECK(check_of("world:every(1/60, function() for i = 1, 10000 do end end)", "expect.events('hit', 0, 2)", options)
            .limit == lua::Limit::none);
}

TEST_CASE("expect outlives its check", "[lua][expect]") {
  lua::Script script({});
  script.load_string(
      "local feder = require 'feder'\nreturn feder.scene { build = function(world, scene) world:every(0.01, function() "
      "if kept then kept(false, 'later') end end) end,\ncheck = function(world, scene, expect) kept = expect "
      "expect(true) "
      "end }",
      "scene.lua");
  script.build();
  CHECK(script.check().passed == 1);
  script.step();
  CHECK(script.checks().failures.size() == 1);
  REQUIRE(script.handler_errors().size() == 1);
  CHECK(script.handler_errors()[0].message == "later");
}

TEST_CASE("expectations of the file and of build count, those of an earlier build do not", "[lua][expect]") {
  lua::Script script({});
  script.load_string(
      "local feder = require 'feder'\nfeder.expect(false, 'load')\nreturn feder.scene { build = function() "
      "feder.expect(false, 'build') end }",
      "scene.lua");
  script.build();
  CHECK(script.checks().failures.size() == 2);
  script.build();
  CHECK(script.checks().failures.size() == 1);
}

TEST_CASE("lines that ran and could run are counted", "[lua][coverage]") {
  lua::Coverage lines;
  lua::HostOptions options;
  options.coverage = &lines;
  // a file in a temporary folder
  const auto file = std::filesystem::temp_directory_path() / "feder_coverage_test.lua";
  FILE* out = std::fopen(file.c_str(), "w");
  REQUIRE(out);
  std::fputs(
      "local n = 0\nfor i = 1, 5 do\n  n = n + i\nend\nlocal function never(x)\n  if x then\n    return n\n  end\n\n"
      "  return -- a comment\nend\nlocal co = coroutine.wrap(function()\n  n = 9\nend)\nco()\n",
      out);
  std::fclose(out);
  lua::Script script(options);
  script.load_file(file);
  std::filesystem::remove(file);
  REQUIRE(lines.size() == 1);
  const lua::LineCounts& counts = lines.begin()->second;
  CHECK(counts.at(1) == 1);
  CHECK(counts.at(3) == 5);
  for (const int line : {6, 7, 10}) CHECK(counts.at(line) == 0);
  CHECK(counts.at(13) == 1);
  for (const int line : {8, 9}) CHECK(!counts.contains(line));
}
