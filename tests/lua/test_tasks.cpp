// Timers and tasks: exact steps, order, cancelling, errors that say where the task was made.
#include "support/script.h"

using namespace feder::test;

TEST_CASE("timers fire at exact steps", "[lua][tasks]") {
  CHECK(output_of(R"(
    local w = feder.world{ dt = 1 / 60 }
    w:after(2, function() print("after", w:step_count()) end)
    w:after(0, function() print("now", w:step_count()) end)
    local n, steps = 0, {}
    local c = w:every(0.025, function() n = n + 1; steps[#steps + 1] = w:step_count() end)
    w:step(60)
    print(n, table.concat(steps, " ", 1, 6), steps[#steps])
    print(c:disconnect(), c:disconnect())
    w:step(60)
    print(n)
  )") == "now\t1\n40\t2 3 5 6 8 9\t60\ntrue\tfalse\nafter\t120\n40\n");
}

TEST_CASE("an every() shorter than a step fires once per step", "[lua][tasks]") {
  CHECK(output_of("local n = 0 world:every(1e-9, function() n = n + 1 end) world:step(7) print(n)") == "7\n");
}

TEST_CASE("tasks wait in simulated time", "[lua][tasks]") {
  CHECK(output_of(R"(
    local w = feder.world{ dt = 0.01 }
    local t = w:task(function()
      print("start", w:step_count())
      feder.wait(1)
      print("one", w:step_count())
      feder.wait_until(function() return w:time() > 1.5 end)
      print("until", w:step_count())
      feder.wait(0)
      print("zero", w:step_count())
      local ok, message = pcall(function() feder.wait(0.1) error("inside", 0) end)
      print(ok, message, w:step_count())
    end)
    print("made", t:alive())
    w:step(300)
    print(t:alive())
  )") == "start\t0\nmade\ttrue\none\t100\nuntil\t151\nzero\t152\nfalse\tinside\t162\nfalse\n");
}

TEST_CASE("wait_for gives a copy of the event", "[lua][tasks]") {
  CHECK(output_of(R"(
    world:body{ name = "floor", type = "static", shape = feder.plane() }
    local ball = world:body{ name = "ball", shape = feder.sphere(0.5), position = {0, 0.6, 0} }
    world:task(function()
      local e = feder.wait_for("contact_begin", { object = ball })
      print(e.kind, e.b:name())
      feder.wait(0.5)
      print(e.b:name())
    end)
    world:step(60)
  )") == "contact_begin\tball\nball\n");
}

TEST_CASE("a cancelled task closes its variables and never runs again", "[lua][tasks]") {
  CHECK(output_of(R"(
    local t = world:task(function()
      local guard <close> = setmetatable({}, { __close = function() print("closed") end })
      feder.wait(0.1)
      print("never")
    end)
    world:step(2)
    print(t:cancel(), t:alive(), t:cancel())
    world:step(20)
  )") == "closed\ntrue\tfalse\tfalse\n");
}

TEST_CASE("an error in a task names the line that made it", "[lua][tasks]") {
  const Ran ran = run("\nworld:task(function()\n  feder.wait(0.1)\n  error('oops')\nend)\nworld:step(20)\nprint('on')");
  CHECK(ran.error == "");
  CHECK(ran.output == "on\n");
  REQUIRE(ran.errors.size() == 1);
  CHECK(ran.errors[0].where == "test.lua:4");
  CHECK(ran.errors[0].message == "oops (in the task made at test.lua:2)");
}

TEST_CASE("waiting belongs to the task's own coroutine", "[lua][tasks]") {
  const Ran ran = run("world:task(function() coroutine.wrap(function() feder.wait(1) end)() end) world:step()");
  REQUIRE(ran.errors.size() == 1);
  CHECK_THAT(ran.errors[0].message, Catch::Contains("feder.wait: called in another coroutine"));
  CHECK(output_of("world:task(function() coroutine.yield() print(world:step_count()) end) world:step(3)") == "1\n");
}

TEST_CASE("tasks may make and cancel tasks", "[lua][tasks]") {
  CHECK(output_of(R"(
    local inner
    world:task(function()
      inner = world:task(function() feder.wait(1) print("never") end)
      feder.wait(0.5)
      inner:cancel()
      world:task(function() feder.wait(0.1) print("second", world:step_count()) end)
    end)
    world:step(100)
  )") == "second\t36\n");
}
