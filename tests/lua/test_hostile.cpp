// Scripts that mean harm or nothing: every API function called with every kind of wrong value. Nothing may crash, and
// the world stays finite.
#include <map>
#include <set>

#include "lua/docs.h"
#include "state/bodies.h"
#include "support/script.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("every function is documented once", "[lua][docs]") {
  std::set<std::string> seen;
  for (const lua::DocRow& row : lua::docs(lua::parts())) {
    CAPTURE(row.owner, row.name);
    CHECK(seen.insert(row.owner + ":" + row.name).second);
    CHECK(row.signature.find(row.name) != std::string::npos);
    CHECK(!row.doc.empty());
  }
  CHECK(seen.size() > 100);
}

TEST_CASE("a joint whose one body sleeps", "[lua][hostile]") {
  CHECK(output_of("local a = world:body{ shape = feder.box(1, .2, .3), position = {0, 5, 0} } "
                  "local b = world:body{ shape = feder.box(1, .2, .3), position = {1, 5, 0} } "
                  "world:joint{ type = 'ball', a = a, b = b, anchor = {.5, 5, 0} } "
                  "b:sleep() world:step() a:sleep() world:step() b:wake() b:sleep() a:wake() world:step(3) "
                  "print(world:is_finite())") == "true\n");
}

TEST_CASE("wrong values never crash and never reach the state", "[lua][hostile]") {
  const int seed = GENERATE(1, 2, 3);
  std::string names;
  for (const lua::DocRow& row : lua::docs(lua::parts())) {
    // those that end the experiment
    if (row.name == "close" || row.name == "step" || row.name == "wait" || row.name == "wait_for" ||
        row.name == "wait_until")
      continue;
    names += "{'" + row.owner + "','" + row.name + "'},";
  }
  lua::HostOptions options;
  options.has_seed = true, options.seed = static_cast<std::uint64_t>(seed);
  options.memory_limit = 256 << 20;
  const Ran ran = run("local names = {" + names + "}\n" + R"(
    local function objects()
      local o = { world = world, feder = feder, shape = feder.box(1, 1, 1), buffer = feder.buffer(9), connection = world:after(1e6, print) }
      o.body = world:body{ name = "b", shape = feder.box(1, 1, 1), position = { 0, 0.5 + math.random(9), 0 } }
      local c = world:body{ shape = feder.sphere(1), position = { 3, 0.5, 0 } }
      o.object = c
      o.joint = world:joint{ type = "ball", a = o.body, b = c }
      o.net = world:net{ points = { {0, 9, 0}, {1, 9, 0} }, springs = { {1, 2} } }
      o.force = world:force{ each = function() end }
      o.region = world:region{ box = { {0, 0, 0}, {1, 1, 1} } }
      o.task = world:task(function() coroutine.yield() end)
      return o
    end
    world:body{ type = "static", shape = feder.plane() }
    local cycle = {} cycle[1] = cycle cycle.x = cycle cycle.shape = cycle
    local trap = setmetatable({}, { __index = function() error("trap") end, __len = function() return 1e15 end, __pairs = error })
    local dead = world:body{ shape = feder.sphere(1) } dead:destroy()
    local other = feder.world{}:body{ shape = feder.sphere(1) }
    local function values(o)
      return { nil, 0/0, 1/0, -1/0, -1, 0, 1, 2.5, 1e300, -1e300, 1e-300, math.maxinteger, math.mininteger, 1e12, "", "1", "x", "\0", ("x"):rep(5000),
               true, false, {}, {1, 2, 3}, {0/0, 1, 2}, {1e300, 0, 0}, cycle, trap, print, function() return 0/0 end, coroutine.create(print), feder,
               world, o.body, o.joint, o.net, o.force, o.region, o.shape, o.buffer, dead, other, { shape = o.shape }, { box = cycle },
               { points = { {0, 0, 0} }, springs = cycle }, { a = o.body, type = "ball" }, { tag = "x" }, "hit", "ball", "contact_begin" }, 49
    end
    local calls, bad = 0, 0
    for round = 1, 2500 do
      local o = round % 50 == 1 and objects() or kept
      kept = o
      local vs, n = values(o)
      local entry = names[math.random(#names)]
      local target = o[entry[1]]
      if math.random(10) == 1 then target = vs[math.random(n)] end
      local args, count = {}, math.random(0, 5)
      for i = 1, count do args[i] = vs[math.random(n)] end
      local ok, message = pcall(function()
        if entry[1] == "feder" then return feder[entry[2]](table.unpack(args, 1, count)) end
        return target[entry[2]](target, table.unpack(args, 1, count))
      end)
      calls = calls + 1
      if not ok then
        bad = bad + 1
        assert(type(message) == "string" and message ~= "", entry[2])
      end
      if round % 20 == 0 then world:set_gravity(0, -9.81, 0) world:step() end
      if round % 100 == 0 then for _, b in ipairs(world:bodies()) do if b:type() ~= "static" then b:destroy() end end end
    end
    print(calls, bad > 500, world:is_finite())
  )",
                      options);
  CAPTURE(seed, ran.error, ran.output);
  CHECK(ran.error == "");
  CHECK(ran.output.find("2500\ttrue\ttrue\n") != std::string::npos);
}
