// The stubs as an editor takes them: every annotation is of the documented form, every script of the project agrees
// with them, call by call and key by key, and mistakes are found by them.
#include <sstream>

#include "cli/program.h"
#include "cli/stub_check.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

namespace fs = std::filesystem;

const std::string& text() {
  static const std::string all = Program().run("doc --luacats").out;
  return all;
}
const LuaStubs& stubs() {
  static const LuaStubs all = read_stubs(text());
  return all;
}

StubFindings findings(const std::string& lua, const LuaStubs& by) {
  return check_with_stubs(lua, by, FEDER_SOURCE_DIR "/scripts");
}

// All scripts of the project; how many of them do not agree.
int disagree(const LuaStubs& by, StubFindings& sum) {
  int count = 0;
  for (const char* folder : {FEDER_SOURCE_DIR "/scenes", FEDER_SOURCE_DIR "/scripts"})
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".lua") continue;
      const StubFindings found = findings(read_file(entry.path()), by);
      for (const std::string& error : found.errors) sum.errors.push_back(entry.path().string() + ":" + error);
      count += !found.errors.empty();
      sum.calls += found.calls, sum.typed += found.typed, sum.arguments += found.arguments, sum.keys += found.keys;
    }
  return count;
}

// A scene with this line in its build, and one that makes what the line may need.
std::string with_line(const std::string& line) {
  return "local feder = require \"feder\"\nlocal build = require \"feder.build\"\nreturn feder.scene { "
         "build = function(world, scene)\n"
         "local ball = world:body { shape = feder.sphere(1) }\n"
         "local net = world:net { points = { { 0, 0, 0 }, { 1, 0, 0 } }, springs = { { 1, 2, stiffness = 5 } } }\n" +
         line + "\nend }";
}

struct Line {
  const char *lua, *told;
};

constexpr Line kMistakes[] = {
    {"feder.sfere(1)", "feder has no sfere"},
    {"world:bdy {}", "feder.World has no method bdy"},
    {"ball:set_velocty(1, 2, 3)", "feder.Body has no method set_velocty"},
    {"build.cain {}", "the module has no cain"},
    {"world:body { shap = feder.sphere(1) }", "no option shap"},
    {"world:body { shape = feder.sphere(1), friction = { statik = 1 } }", "no option statik"},
    {"feder.world { rigid = { solvr = 'impulse' } }", "no option solvr"},
    {"world:on('colision', function(e) end)", "kind: expected"},
    {"world:on('hit', { min_sped = 1 }, function(e) end)", "no option min_sped"},
    {"world:on('sleep', { min_speed = 1 }, function(e) end)", "no option min_speed"},
    {"world:on('hit', function(e) print(e.sped) end)", "feder.HitEvent has no sped"},
    {"for e in world:events('hit') do print(e.sped) end", "feder.HitEvent has no sped"},
    {"net:point()", "argument i is missing"},
    {"net:point(1, 2)", "at most 1 arguments, got 2"},
    {"ball:set_velocity(1)", "argument y is missing"},
    {"feder.box(1, 1, 1, 1)", "at most 3 arguments, got 4"},
    {"build.chain({}, 1)", "at most 1 arguments, got 2"},
    {"world:body { shape = feder.sphere(1), density = 'heavy' }", "density: expected number, got \"heavy\""},
    {"world:body { shape = feder.sphere(1), type = 'statik' }", "type: expected"},
    {"world:body { shape = ball }", "shape: expected feder.Shape, got feder.Body"},
    {"world:body { shape = feder.sphere(1), position = 3 }", "position: expected number[], got integer"},
    {"world:body { shape = feder.sphere(1), position = { 0, '1', 0 } }", "position: expected number, got \"1\""},
    {"world:after(1, 2)", "fn: expected function, got integer"},
    {"world:after(1, function(e) end)", "a function of at most 0 parameters"},
    {"net:attach(1, world)", "got feder.World"},
    {"world:joint { type = 'ball', a = net }", "a: expected feder.Body, got feder.Net"},
    {"ball:set_gravity_scale(true)", "s: expected number, got true"},
};

// What is right in several forms, so that nothing is said of it.
constexpr const char* kRight[] = {
    "ball:set_velocity { 1, 2, 3 }",
    "ball:set_rotation { axis = { 0, 1, 0 }, angle = 1 }",
    "ball:apply_force({ 1, 2, 3 }, { 0, 0, 0 })",
    "ball:apply_force(1, 2, 3, 0, 0, 0)",
    "ball:set_friction { static = 1, dynamic = 0.5 }",
    "ball:set_sensor('all')",
    "world:raycast({ 0, 5, 0 }, { 0, -1, 0 }, 10, { sensors = true })",
    "world:raycast(0, 5, 0, 0, -1, 0)",
    "if world:find('ball') then world:find('ball'):set_velocity(1, 2, 3) end",
    "world:on('hit', { min_speed = 1 }, function(e) e.b:destroy() end)",
    "ball:on('hit', function(e) print(e.other:name(), e.speed) end)",
    "world:joint { type = 'hinge', a = ball, axis = { 0, 0, 1 } }:set_limits { -1, 1 }",
    "world:set_gravity { 0, -5, 0 }",
    "net:add_spring(1, 2, { stiffness = 5 })",
    "feder.box { 1, 2, 3 }",
};

}  // namespace

TEST_CASE("every annotation of the stubs is of the documented form and names types that there are", "[cli][stubs]") {
  CHECK(stubs().errors == std::vector<std::string>{});
  CHECK(stubs().classes.size() > 60);
  for (const char* bad : {"---@class\n", "---@field x? number\n", "---@class feder.A : feder.Nobody\n",
                          "---@overload function(x)\n", "---@param x number[\nfunction f(x) end\n", "---@parm x any\n",
                          "---@class feder.A\n---@field x { y?: fun(): number, z?: number }\n"})
    CHECK(!read_stubs(bad).errors.empty());
}

TEST_CASE("every call and every option of all scripts agrees with the stubs", "[cli][stubs]") {
  StubFindings sum;
  disagree(stubs(), sum);
  CHECK(sum.errors == std::vector<std::string>{});
  // it has looked at something, and mostly knew at what
  CAPTURE(sum.calls, sum.typed, sum.arguments, sum.keys);
  CHECK(sum.calls > 1500);
  CHECK(sum.typed > 0.85 * sum.calls);
  CHECK(sum.arguments > 2500);
  CHECK(sum.keys > 2000);
}

TEST_CASE("stubs that miss a name, an argument or a type disagree with the scripts", "[cli][stubs]") {
  // every line that has `from`, with `to` in its place; without `to`, no such line
  const auto scripts_against = [](const std::string& from, const std::string& to = "") {
    std::istringstream in(text());
    std::string other;
    for (std::string line; std::getline(in, line); other += line.empty() ? "" : line + "\n") {
      const std::size_t at = line.find(from);
      if (at != std::string::npos) line = to.empty() ? "" : line.replace(at, from.size(), to);
    }
    StubFindings sum;
    return disagree(read_stubs(other), sum);
  };
  CHECK(scripts_against("no line has this") == 0);
  CHECK(scripts_against("@field friction?") > 10);
  CHECK(scripts_against("@field density? number", "@field density? string") > 10);
  CHECK(scripts_against("@param depth? number") > 10);
  CHECK(scripts_against("@param degrees number", "@param degrees string") > 1);
  CHECK(scripts_against("function body:position", "function body:place") > 10);
  CHECK(scripts_against("@field min_speed?") > 1);
}

TEST_CASE("mistakes in a script are found by the stubs, and what is right passes", "[cli][stubs]") {
  for (const Line& mistake : kMistakes) {
    CAPTURE(mistake.lua);
    const StubFindings found = findings(with_line(mistake.lua), stubs());
    REQUIRE(found.errors.size() == 1);
    CHECK_THAT(found.errors[0], Catch::StartsWith("6: ") && Catch::Contains(mistake.told));
  }
  for (const char* line : kRight) {
    CAPTURE(line);
    CHECK(findings(with_line(line), stubs()).errors == std::vector<std::string>{});
    // and it does run
    const Program p;
    p.write("right.lua", with_line(line));
    const Outcome out = p.run("run right.lua --steps 1");
    CAPTURE(out.err);
    CHECK(out.status == 0);
  }
}
