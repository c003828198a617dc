// feder check: names that nothing has are found where they stand, with the nearest name; what only looks like a mistake
// is not.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

struct Mistake {
  const char* what;
  std::string text;     // of mistake.lua
  const char* message;  // behind "mistake.lua:"
};

const char* const kFeder = "local feder = require 'feder'\n";

std::string in_build(const std::string& text) { return scene(text); }  // from line 5 on

const Mistake kMistakes[] = {
    // one of each kind
    {"key of a scene", std::string(kFeder) + "return feder.scene { secnds = 3, build = function(world) end }\n",
     "2: feder.scene: unknown option 'secnds'; did you mean 'seconds'?"},
    {"option", in_build("world:body {\n shap = feder.sphere(1) }"),
     "6: world:body: unknown option 'shap'; did you mean 'shape'?"},
    {"event", in_build("world:on('colision', function(e) end)"),
     "5: unknown event 'colision'; did you mean 'contact_begin'?"},
    {"module", std::string(kFeder) + "local build = require \"feder.bild\"\n",
     "2: no module 'feder.bild'; did you mean 'feder.build'?"},
    {"global that is a parameter", in_build("wrld:body { shape = feder.sphere(1) }"),
     "5: nothing is called 'wrld'; did you mean 'world'?"},
    {"global that is a library", in_build("\nprint(Math.abs(-3))"),
     "6: nothing is called 'Math'; did you mean 'math'?"},
    {"function of a library", in_build("print(string.frmat('%d', 3))"),
     "5: string has no 'frmat'; did you mean 'format'?"},
    {"function of feder", in_build("world:body { shape = feder.sfere(1) }"),
     "5: feder has no 'sfere'; did you mean 'sphere'?"},
    {"method of a world", in_build("world:bdy { shape = feder.sphere(1) }"),
     "5: a world has no method 'bdy'; did you mean 'body'?"},
    // in functions that nothing runs
    {"method of a body in a handler",
     in_build("local b = world:body { shape = feder.sphere(1) }\nworld:on('hit', function(e)\n b:positoin()\nend)"),
     "7: a body has no method 'positoin'; did you mean 'position'?"},
    {"method of a field of the scene in check", scene(kBall, "expect(scene.ball:positoin() > 0)"),
     "8: a body has no method 'positoin'; did you mean 'position'?"},
    {"expectation in a check", scene(kBall, "expect.setles(scene.ball)"),
     "8: expect has no 'setles'; did you mean 'settles'?"},
    {"method of an element of a list",
     in_build(
         "scene.all = {}\nfor i = 1, 3 do scene.all[i] = world:body { shape = feder.sphere(1) } end\nworld:after(1, "
         "function() for _, b in ipairs(scene.all) do b:wkae() end end)"),
     "7: a body has no method 'wkae'; did you mean 'wake'?"},
    {"method of a list of bodies", in_build("for _, b in ipairs(world:bodies()) do b:velocty() end"),
     "5: a body has no method 'velocty'; did you mean 'velocity'?"},
    {"method of what a function of the script is given",
     std::string(kFeder) + "local function kick(b) b:aply_impulse(0, 1, 0) end\nreturn feder.scene { build = "
                           "function(world) kick(world:body { shape = feder.sphere(1) }) end }\n",
     "2: a body has no method 'aply_impulse'; did you mean 'apply_impulse'?"},
    {"method of what a function of the script returns",
     std::string(kFeder) +
         "local function ball(w) return w:body { shape = feder.sphere(1) } end\nlocal w = feder.world "
         "{}\nball(w):slep()\n",
     "4: a body has no method 'slep'; did you mean 'sleep'?"},
    {"method of a world that a module is given",
     std::string(kFeder) + "local M = {}\nfunction M.tower(world) world:bdy {} "
                           "end\nreturn M\n",
     "3: a world has no method 'bdy'; did you mean 'body'?"},
    {"method that another language would have",
     in_build("local b = world:body { shape = feder.sphere(1) }\nb:getPosition()"),
     "6: a body has no method 'getPosition'; did you mean 'position'?"},
    {"method of a string", in_build("print(('%d'):fromat(3))"), "5: string has no 'fromat'; did you mean 'format'?"},
    // events
    {"field of an event", in_build("world:on('hit', function(e) print(e.sped) end)"),
     "5: event hit: no field 'sped'; did you mean 'speed'?"},
    {"field of another event", in_build("world:on('hit', function(e) print(e.cause) end)"),
     "5: event hit: no field 'cause'; known: "},
    {"field of an event in a named handler",
     in_build("local function heard(e) print(e.sped) end\nworld:on('hit', heard)"),
     "5: event hit: no field 'sped'; did you mean 'speed'?"},
    {"other in a handler of the world", in_build("world:on('hit', function(e) print(e.other) end)"),
     "5: event hit: no field 'other'; "},
    {"field of an event in a loop", in_build("for e in world:events('hit') do print(e.sped) end"),
     "5: event hit: no field 'sped'; did you mean 'speed'?"},
    {"filter", in_build("world:on('hit', { min_sped = 2 }, function(e) end)"),
     "5: world:on(\"hit\"): unknown option 'min_sped'; did you mean 'min_speed'?"},
    {"event that a task waits for", in_build("world:task(function() feder.wait_for('hitt') end)"),
     "5: unknown event 'hitt'; did you mean 'hit'?"},
    {"method of what an event tells", in_build("world:on('hit', function(e) print(e.a:nme()) end)"),
     "5: an object has no method 'nme'; did you mean 'name'?"},
    {"method of what is found", in_build("world:find('x'):psition()"),
     "5: an object has no method 'psition'; did you mean 'position'?"},
    // tables in tables
    {"option of the world",
     std::string(kFeder) + "return feder.scene { world = { gravty = { 0, 0, 0 } }, build = print }\n",
     "2: feder.scene.world: unknown option 'gravty'; did you mean 'gravity'?"},
    {"option of a system",
     std::string(kFeder) + "return feder.scene { world = { rigid = { solvr = 'impulse' } }, build = print }\n",
     "2: feder.scene.world.rigid: unknown option 'solvr'; did you mean 'solver'?"},
    {"option of a material", std::string(kFeder) + "local w = feder.world { materials = { ice = { frction = 0 } } }\n",
     "2: feder.world.materials: unknown option 'frction'; did you mean 'friction'?"},
    {"option in an option", in_build("world:body { shape = feder.sphere(1), friction = { statc = 1 } }"),
     "5: world:body.friction: unknown option 'statc'; did you mean 'static'?"},
    {"options in a variable", in_build("local o = { shape = feder.sphere(1), densty = 3 }\nworld:body(o)"),
     "5: world:body: unknown option 'densty'; did you mean 'density'?"},
    {"option of the world at the top", std::string(kFeder) + "return feder.scene { dimension = 2, build = print }\n",
     "2: feder.scene: 'dimension' belongs into `world = { ... }`"},
    {"system at the top", std::string(kFeder) + "return feder.scene { rigid = {}, build = print }\n",
     "2: feder.scene: 'rigid' belongs into `world = { rigid = { ... } }`"},
    {"choice", in_build("world:body { shape = feder.sphere(1), type = 'dynamik' }"),
     "5: world:body.type: expected one of static, kinematic, dynamic, got 'dynamik'"},
    {"function of a module", std::string(kFeder) + "local build = require 'feder.build'\nprint(build.latice)\n",
     "3: the module feder.build has no 'latice'; did you mean 'lattice'?"},
};

// What is right, and looks wrong to who does not read closely. Each is a file of its own.
const char* const kRight[] = {
    // locals that have the names of others
    "local world = { bdy = function() end }\nworld:bdy()\n",
    "local string = { frmat = function() end }\nstring.frmat()\n",
    "local feder = { sfere = function() end }\nfeder.sfere()\n",
    "local Math = math\nprint(Math.abs(-1))\n",
    "local function shows(feder, math) return feder.sfere, math.flor end\nprint(shows({}, {}))\n",
    // a class of the script's own, with a method near to one of a world
    "local World = {}\nWorld.__index = World\nfunction World.new() return setmetatable({ size = 1 }, World) end\n"
    "function World:bodys() return self.size end\nlocal world = World.new()\nprint(world:bodys())\n",
    // globals that the script makes, before or after they are read, and tests for what may be missing
    "function later() return now_it_is_there end\nnow_it_is_there = 1\n_G.also = 2\nprint(later(), also)\n",
    "if jit then print('no') end\nlocal unpack = unpack or table.unpack\nprint(unpack { 1 }, not bit32, setfenv == "
    "nil)\n",
    "setmetatable(_G, { __index = function() return 1 end })\nprint(whatever)\n",
    "load('whatever = 1')()\nprint(whatever)\n",
    "local name = 'string'\nrequire(name)\nprint(whatever)\n",
    "local _ENV = { print = print }\nprint(whatever)\n",
    "string.trim = function(s) return (s:gsub('^%s+', '')) end\nprint(string.trim(' x'), (' x'):trim())\n",
    "local feder = require 'feder'\nfeder.twice = function(x) return 2 * x end\nprint(feder.twice(2))\n",
    // variables of two kinds, and of one that comes later
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal thing = w:body { shape = feder.sphere(1) }\n"
    "if w:time() > 0 then thing = { fly = function() end } end\nif thing.fly then thing:fly() end\n",
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal hose\nlocal function stop() hose:stop() end\n"
    "hose = { stop = print }\nstop()\n",
    // comments and strings
    "-- feder.none, wrld:bdy {}\n--[==[ world:on('colision') ]] ]==]\nprint('wrld:body { shap = 1 }', "
    "[[feder.none]])\n",
    // a table of the script with keys of its own
    "local feder = require 'feder'\nreturn feder.scene { build = function(world, scene)\n  scene.log = { shap = 1, "
    "secnds = 2 "
    "}\n  scene.log.whatever = 3\n  scene.mine = { positoin = function() end }\n  scene.mine:positoin()\nend }\n",
    // one handler for two kinds of events
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal function heard(e) print(e.speed, e.cause) end\n"
    "w:on('hit', heard)\nw:on('wake', heard)\n",
    // the other one in a handler of an object
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal b = w:body { shape = feder.sphere(1) }\n"
    "b:on('hit', function(e) print(e.other, e:copy().mine) end)\n",
    // objects whose class only the run knows
    "local feder = require 'feder'\nlocal w = feder.world {}\nw:on('hit', function(e) e.a:velocity() e.b:set_point(1, "
    "0, "
    "0, 0) end)\nw:find('x'):set_motor(1, 2)\n",
    // what must fail
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal good = pcall(function() w:body { shap = 1 } end)\n"
    "local there = pcall(require, 'none.such')\nprint(good, there)\n",
    // names that a script makes up: materials, axes, parameters of formulas
    "local feder = require 'feder'\nreturn feder.scene { world = { materials = { mine = { friction = 1 } } },\n"
    "  study = { error = function(world) return world:time() end, reference = 0, axes = { dt = { 1 }, mine = { from = "
    "1, to "
    "= 2, step = 1 } } },\n  build = function(world) world:force { each = '-k*x', params = { k = 1 } } end }\n",
    // what needs itself
    "local function f() return f() end\nlocal function g(x) return x and g(x) or f(g) end\nlocal a, b\na = b\nb = a\n"
    "local t = {}\nt[1] = t[1]\nfor _, v in ipairs(t) do t[2] = v end\nprint(f, g, a, b)\n"
    "function even(n) return odd(n - 1) end\nfunction odd(n) return even(n - 1) end\n",
    // an options table that grows
    "local feder = require 'feder'\nlocal w = feder.world {}\nlocal o = {}\no.shape = feder.sphere(1)\nw:body(o)\n",
    // Lua 5.4 in full
    "for i = 1, 2 do if i > 1 then goto next end ::next:: end\nlocal x <const>, y <close> = 0x1p-4, nil\nprint(x // 1 "
    "| ~x << 2, x ~= y, #'a' .. 'b' .. 1e-3, -2 ^ "
    "-2)\n"
    "do return (function(...) return ... end)(1, [==[\n]]]==], '\\z\n   \\x41\\u{48}\\65', { [1] = 2; 3, f = "
    "1 }) "
    "end\n",
};

}  // namespace

TEST_CASE("check finds a name that nothing has, where it stands, with the nearest one", "[cli][check]") {
  const Program p;
  for (const Mistake& m : kMistakes) {
    CAPTURE(m.what, m.text);
    p.write("mistake.lua", m.text);
    const Outcome o = p.run("check mistake.lua");
    CAPTURE(o.err);
    CHECK(o.status == 1);
    CHECK(count_lines(o.err) == 1);
    CHECK(o.err.find(std::string("mistake.lua:") + m.message) == 0);
  }
}

TEST_CASE("check says nothing about what is right", "[cli][check]") {
  const Program p;
  int number = 0;
  for (const char* text : kRight) p.write("right" + std::to_string(++number) + ".lua", text);
  const Outcome o = p.run("check .");
  CHECK(o.err == "");
  CHECK(o.status == 0);
  CHECK(o.out == std::to_string(number) + " files: nothing found\n");
}

TEST_CASE("check knows the modules beside a scene, and what they make", "[cli][check]") {
  const Program p;
  p.write("level.lua",
          "local feder = require 'feder'\nlocal crates = require 'parts.crates'\nprint(crates.tower, shared)\n"
          "print(crates.towr)\nlevel_size = 3\n");
  p.write("parts/crates.lua",
          "local wheels = require 'parts.wheels'\nshared = level_size\nlocal M = { wheels = wheels }\nfunction "
          "M.tower() end\n"
          "return M\n");
  p.write("parts/wheels.lua", "return { count = 4 }\n");
  const Outcome o = p.run("check .");
  CHECK(o.err == "./level.lua:4: the module parts.crates has no 'towr'; did you mean 'tower'?\n");
}

TEST_CASE("check says nothing about the scenes and scripts that come with feder", "[cli][check]") {
  const Program p;
  const Outcome o = p.run("check $S $S/../scripts --json");
  CHECK(o.err == "");
  CHECK(o.status == 0);
  CHECK(o.json()["findings"].empty());
  CHECK(o.json()["files"] > 40);
}

TEST_CASE("check goes through all files, and says what cannot be loaded", "[cli][check]") {
  const Program p;
  p.write("a.lua", "local x = = 2\n");
  p.write("b.lua", "print(wrng)\n");
  p.write("c.yaml", "title: x\nbodies:\n  - shape: { sphere: 1 }\n    densty: 3\n");
  p.write("data.yaml", "densty: 3\n");
  const Outcome o = p.run("check .");
  CAPTURE(o.err);
  CHECK(o.status == 3);
  CHECK(count_lines(o.err) == 3);
  CHECK(o.err.find("a.lua:1: ") != std::string::npos);
  CHECK(o.err.find("b.lua:1: ") != std::string::npos);
  CHECK(o.err.find("c.yaml:4: ") != std::string::npos);
  CHECK(o.err.find("'density'") != std::string::npos);
  const auto findings = p.run("check . --json").json()["findings"];
  REQUIRE(findings.size() == 3);
  CHECK(findings[2]["line"] == 4);
  CHECK(p.run("check nothing.lua").status == 3);
  CHECK(p.run("check").status == 2);
}
