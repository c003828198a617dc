// Events: order, filters, orientation, handlers that edit the world, errors that are counted.
#include "state/bodies.h"
#include "support/script.h"

using namespace feder::test;

namespace {
const char* const kFloor = "world:body{ name = 'floor', type = 'static', shape = feder.plane() } ";
const char* const kBall =
    "local ball = world:body{ name = 'ball', shape = feder.sphere(0.5), position = {0, 0.6, 0}, tags = {'ball'} } ";
}  // namespace

TEST_CASE("contacts begin once, with both partners and a place", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    local n = 0
    world:on("contact_begin", function(e)
      n = n + 1
      print(e.kind, e.a:name() .. "/" .. e.b:name(), ("%.1f %.1f"):format(e.y, math.abs(e.ny)))
    end)
    world:step(60)
    print(n)
  )") == "contact_begin\tfloor/ball\t0.0 1.0\n1\n");
}

TEST_CASE("an object's own handler sees itself as a", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    ball:on("contact_begin", function(e) print("ball", e.a:name(), e.b:name(), e.ny < 0) end)
    world:find("floor"):on("contact_begin", function(e) print("floor", e.a:name(), e.b:name(), e.ny > 0) end)
    world:on("contact_begin", { a = ball }, function(e) print("filter", e.a:name(), e.ny < 0) end)
    world:step(30)
  )") == "ball\tball\tfloor\ttrue\nfloor\tfloor\tball\ttrue\nfilter\tball\ttrue\n");
}

TEST_CASE("other is the one that a handler's object meets", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    ball:on("hit", function(e) print("ball", e.other:name(), e:copy().other:name()) end)
    world:find("floor"):on("hit", function(e) print("floor", e.other:name()) end)
    world:on("hit", function(e) print("world", e.other, e:copy().other) end)
    world:step(30)
  )") == "ball\tfloor\tfloor\nfloor\tball\nworld\tnil\tnil\n");
}

TEST_CASE("an event shows its fields as text and to pairs", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    local kept, keys = nil, {}
    world:on("hit", function(e)
      kept = e
      local text = tostring(e)
      print(text:sub(1, 12), text:find('a = body "floor", b = body "ball"', 1, true) ~= nil,
        text:find("speed = " .. e.speed, 1, true) ~= nil, text:find("cause"), text:find("copy"))
      for key, value in pairs(e) do
        keys[#keys + 1] = key
        assert(e[key] == value)
      end
    end)
    world:step(30)
    table.sort(keys)
    print(table.concat(keys, " "))
    print(kept, pcall(pairs, kept))
  )") == "event hit { \ttrue\ttrue\tnil\tnil\na b impulse kind nx ny nz speed step time x y z\n"
         "event (over)\tfalse\ttest.lua:16: pairs: an event is valid inside its handler only; copy it there\n");
}

TEST_CASE("a sensor leaves static bodies out unless it is to see all", "[lua][events]") {
  for (const char* when : {"made", "set"}) {
    CAPTURE(when);
    const std::string changed = std::string(when) + " == 'set'";
    CHECK(output_of(std::string("local made, set = 'made', 'set' local later = ") + changed + R"( or false
      local function zone(name, x, sensor)
        local b = world:body{ name = name, type = "static", shape = feder.box(1, 1, 1), position = {x, 0, 0},
          sensor = later and true or sensor }
        if later then b:set_sensor(sensor) end
        b:on("sensor_enter", function(e) print(name, e.other:name()) end)
        world:body{ name = "wall", type = "static", shape = feder.box(0.1, 0.1, 0.1), position = {x, 0, 0} }
        world:body{ name = "lift", type = "kinematic", shape = feder.box(0.1, 0.1, 0.1), position = {x + 0.2, 0, 0} }
        world:body{ name = "ball", shape = feder.sphere(0.05), position = {x - 0.2, 0, 0} }
      end
      zone("moving", 0, true)
      zone("all", 10, "all")
      world:region{ name = "region", shape = feder.box(1, 1, 1), position = {20, 0, 0} }:on("sensor_enter", function(e)
        print("region", e.other:name())
      end)
      world:body{ name = "wall", type = "static", shape = feder.box(0.1, 0.1, 0.1), position = {20, 0, 0} }
      world:body{ name = "ball", shape = feder.sphere(0.05), position = {20.2, 0, 0} }
      world:step(2)
      print(world:find("moving"):is_sensor(), world:find("all"):is_sensor())
      -- what becomes movable is seen, what becomes scenery is not
      world:step(1)
      world:bodies()[2]:set_type("kinematic")
      world:step(1)
    )") == "moving\tlift\nmoving\tball\nall\twall\nall\tlift\nall\tball\nregion\tball\ntrue\ttrue\nmoving\twall\n");
  }
}

TEST_CASE("filters are kept: tags, speed, objects", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    local hits = { slow = 0, fast = 0, tag = 0, other = 0, object = 0 }
    world:on("hit", { min_speed = 0.1 }, function(e) assert(e.speed >= 0.1) hits.slow = hits.slow + 1 end)
    world:on("hit", { min_speed = 100 }, function() hits.fast = hits.fast + 1 end)
    world:on("hit", { tag = "ball" }, function() hits.tag = hits.tag + 1 end)
    world:on("hit", { tag = "cube" }, function() hits.other = hits.other + 1 end)
    world:on("hit", { object = ball }, function() hits.object = hits.object + 1 end)
    world:step(30)
    print(hits.slow > 0, hits.fast, hits.tag > 0, hits.other, hits.object == hits.tag)
  )") == "true\t0\ttrue\t0\ttrue\n");
}

TEST_CASE("an event is valid inside its handler; a copy stays", "[lua][events]") {
  CHECK(error_of(std::string(kFloor) + kBall +
                 "local kept world:on('contact_begin', function(e) kept = e end) world:step(30) print(kept.x)") ==
        "test.lua:1: event.x: an event is valid inside its handler only; keep it with e:copy()");
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    local kept
    world:on("contact_begin", function(e) kept = e:copy() end)
    world:step(30)
    print(type(kept), kept.kind, kept.b:name(), kept.speed, kept.step > 0)
  )") == "table\tcontact_begin\tball\tnil\ttrue\n");
  const Ran ran =
      run(std::string(kFloor) + kBall + "world:on('contact_begin', function(e) print(e.spead) end) world:step(30)");
  REQUIRE(ran.errors.size() == 1);
  CHECK(ran.errors[0].message == "event: no field 'spead'; did you mean 'speed'?");
}

TEST_CASE("handlers may destroy and make anything, and begin and end pair", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + R"(
    local begun, ended = 0, 0
    world:on("contact_begin", function(e)
      begun = begun + 1
      if e.b:alive() and e.b:name() ~= "floor" then
        local name = e.b:name()
        e.b:destroy()
        if begun < 5 then world:body{ name = name .. "+", shape = feder.sphere(0.5), position = {begun, 0.6, 0} } end
        world:on("contact_end", function() end):disconnect()
      end
    end)
    world:on("contact_end", function(e) ended = ended + 1; print("end", e.b:name(), e.b:alive(), e.b) end)
    world:body{ name = "x", shape = feder.sphere(0.5), position = {0, 0.6, 0} }
    world:step(120)
    print(begun, ended, #world:bodies())
  )") == "end\tx\tfalse\tbody \"x\"\nend\tx+\tfalse\tbody \"x+\"\nend\tx++\tfalse\tbody \"x++\"\n"
         "end\tx+++\tfalse\tbody \"x+++\"\nend\tx++++\tfalse\tbody \"x++++\"\n5\t5\t1\n");
}

TEST_CASE("handlers run in the order of subscription; one may disconnect another", "[lua][events]") {
  CHECK(output_of(R"(
    local c
    world:on("step", function() print("first") c:disconnect() end)
    c = world:on("step", function() print("never") end)
    world:on("step", function(e)
      print("third", e.step, ("%.3f"):format(e.time))
      if e.step == 1 then world:on("step", function() print("late") end) end
    end)
    world:step(2)
    print(c:disconnect())
  )") == "first\nthird\t1\t0.017\nfirst\nthird\t2\t0.033\nlate\nfalse\n");
}

TEST_CASE("an error in a handler is counted by place and the run goes on", "[lua][events]") {
  const Ran ran =
      run("world:on('step', function() error('bad') end)\n"
          "world:on('step', function() local x = nil; x.y = 1 end)\n"
          "world:on('step', function() error({}) end)\n"
          "world:after(0, function() world:body{ shape = 1 } end)\n"
          "world:step(10)\nprint(world:step_count())");
  CHECK(ran.error == "");
  CHECK(ran.output == "10\n");
  REQUIRE(ran.errors.size() == 4);
  CHECK(ran.errors[0].where == "test.lua:4");
  CHECK(ran.errors[0].message == "world:body.shape: expected a shape (feder.box(1, 1, 1) ...), got 1");
  CHECK(ran.errors[1].where == "test.lua:1");
  CHECK(ran.errors[1].message == "bad");
  CHECK(ran.errors[1].count == 10);
  CHECK(ran.errors[2].where == "test.lua:2");
  CHECK_THAT(ran.errors[2].message, Catch::Contains("attempt to index a nil value"));
  CHECK(ran.errors[3].where == "test.lua:3");
  CHECK(ran.errors[3].message == "error object is a table");
}

TEST_CASE("a handler cannot step or close its world", "[lua][events]") {
  const Ran ran = run(
      "world:on('step', function() world:step() end)\nworld:on('step', function() world:close() end)\nworld:step()");
  CHECK(ran.error == "");
  REQUIRE(ran.errors.size() == 2);
  CHECK_THAT(ran.errors[0].message, Catch::Contains("world:step: the world is in a step"));
  CHECK_THAT(ran.errors[1].message, Catch::Contains("world:close: the world is in use"));
}

TEST_CASE("events can be polled", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + kBall + R"(
    local n = 0
    for i = 1, 30 do
      world:step()
      for e in world:events("contact_begin") do n = n + 1; assert(e.b == ball) end
    end
    print(n)
  )") == "1\n");
}

TEST_CASE("a region reports what enters and leaves", "[lua][events]") {
  CHECK(output_of(R"(
    local zone = world:region{ name = "zone", box = { {-1, 2, -1}, {1, 4, 1} } }
    print(zone, zone:kind(), #world:bodies())
    zone:on("sensor_enter", function(e) print("in", e.sensor:name(), e.other:name(), e.sensor == zone) end)
    zone:on("sensor_leave", function(e) print("out", e.sensor:name(), e.other:name()) end)
    world:body{ name = "ball", shape = feder.sphere(0.2), position = {0, 6, 0} }
    world:step(120)
  )") == "region \"zone\"\tregion\t0\nin\tzone\tball\ttrue\nout\tzone\tball\n");
}

TEST_CASE("sleep and wake carry object and cause", "[lua][events]") {
  CHECK(output_of(std::string(kFloor) + R"(
    local box = world:body{ name = "box", shape = feder.box(1, 1, 1), position = {0, 0.5, 0} }
    world:on("sleep", function(e) print("sleep", e.object:name()) end)
    box:on("wake", function(e) print("wake", e.object:name(), e.cause) end)
    world:step(120)
    box:wake()
    world:step(1)
  )") == "sleep\tbox\nwake\tbox\tscript\n");
}
