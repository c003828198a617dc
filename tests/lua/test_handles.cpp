// Handles: identity, tombstones, other worlds, closed worlds, collection.
#include "state/bodies.h"
#include "support/script.h"

using namespace feder::test;

TEST_CASE("a handle is one value per object", "[lua][handles]") {
  CHECK(output_of(R"(
    local b = world:body{ name = "crate3", shape = feder.sphere(1), tags = {"crate", "red"} }
    print(b, b == world:find("crate3"), world:bodies()[1] == b, b:kind(), b:name(), b:alive(), #b:tags(), b:tags()[1])
    print(world:body{ shape = feder.sphere(1) })
    print(#world:bodies{ tag = "crate" }, #world:bodies{ tag = "blue" }, #world:bodies(), world:find("nobody"))
    local t = { [b] = 1 }
    print(t[world:find("crate3")], getmetatable(b), world)
  )") == "body \"crate3\"\ttrue\ttrue\tbody\tcrate3\ttrue\t2\tcrate\nbody #1\n1\t0\t2\tnil\n1\tfalse\tworld #1\n");
}

TEST_CASE("a destroyed object is named, with the line that destroyed it", "[lua][handles]") {
  const std::string gone = "local b = world:body{ name = 'crate3', shape = feder.sphere(1) }\nb:destroy()\n";
  CHECK(error_of(gone + "print(b:position())") ==
        "test.lua:3: body:position: body \"crate3\" was destroyed at test.lua:2");
  CHECK(error_of(gone + "b:destroy()") == "test.lua:3: body:destroy: body \"crate3\" was destroyed at test.lua:2");
  CHECK(error_of(gone + "world:joint{ type = 'ball', a = b }") ==
        "test.lua:3: world:joint.a: body \"crate3\" was destroyed at test.lua:2");
  CHECK(output_of(gone + "print(b, b:alive(), b:name(), b:kind())") == "body \"crate3\"\tfalse\tcrate3\tbody\n");
  // the slot is used again many times: the message stays
  CHECK(error_of(gone + "for i = 1, 300 do world:body{ shape = feder.sphere(1) }:destroy() end print(b:mass())") ==
        "test.lua:3: body:mass: body \"crate3\" was destroyed at test.lua:2");
}

TEST_CASE("joints go with their bodies and say so", "[lua][handles]") {
  CHECK(error_of(R"(
    local a, b = world:body{ shape = feder.sphere(1) }, world:body{ shape = feder.sphere(1), position = {3, 0, 0} }
    local j = world:joint{ name = "link", type = "ball", a = a, b = b }
    a:destroy()
    print(j:alive())
    j:force()
  )") == "test.lua:6: joint:force: joint \"link\" was destroyed at test.lua:4");
}

TEST_CASE("objects of other and of closed worlds are refused", "[lua][handles]") {
  const std::string two =
      "local other = feder.world{} local a = world:body{ name = 'a', shape = feder.sphere(1) } "
      "local b = other:body{ name = 'b', shape = feder.sphere(1) } ";
  CHECK(error_of(two + "world:joint{ type = 'ball', a = a, b = b }") ==
        "test.lua:1: world:joint.b: body \"b\" belongs to another world");
  CHECK(error_of(two + "other:close() b:position()") == "test.lua:1: body:position: body #0 belongs to a closed world");
  CHECK(error_of(two + "other:close() other:step()") == "test.lua:1: world:step: the world is closed");
  CHECK(output_of(two + "other:close() other:close() print(b:alive(), a:alive())") == "false\ttrue\n");
}

TEST_CASE("collecting handles destroys nothing, collecting worlds is safe", "[lua][handles]") {
  CHECK(output_of(R"(
    for i = 1, 50 do world:body{ name = "n" .. i, shape = feder.sphere(1), position = {0, i * 3, 0} } end
    collectgarbage()
    local t = {} for i = 1, 20000 do t[i] = { i } end
    print(#world:bodies(), world:find("n7"):name())
    for i = 1, 40 do
      local w = feder.world{}
      w:body{ shape = feder.sphere(1) }
      w:on("step", function() w:find("x") end)
      w:step(2)
    end
    print(#world:bodies())
  )") == "50\tn7\n50\n");
}

TEST_CASE("methods check what they are called on", "[lua][handles]") {
  const std::string make =
      "local b = world:body{ shape = feder.sphere(1) } local j = world:joint{ type = 'ball', a = b } ";
  for (const char* bad : {"b.position(j)", "b.position(world)", "b.position()", "b.position('x')", "j.force(b)",
                          "world.step(b)", "world.body(b, {})", "b.destroy({})", "feder.buffer(1).fill(b, 1)"}) {
    CAPTURE(bad);
    CHECK_THAT(error_of(make + bad), Catch::Contains("before the ':', got"));
  }
}
