// Queries, snapshots, conserved quantities, joints, forces, nets and buffers through the API.
#include "state/bodies.h"
#include "support/script.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("ray casts answer with object, place, normal and distance", "[lua][world]") {
  CHECK(output_of(R"(
    print(world:raycast(0, 5, 0, 0, -1, 0), #world:report().systems)
    local floor = world:body{ name = "floor", type = "static", shape = feder.plane() }
    local ball = world:body{ name = "ball", shape = feder.sphere(1), position = {3, 1, 0}, group = 2 }
    local function show(o, x, y, z, nx, ny, nz, d) print(o, o and ("%.3f %.3f %.3f  %.2f %.2f %.2f  %.3f"):format(x, y, z, nx + 0.001, ny, nz + 0.001, d)) end
    show(world:raycast(0, 5, 0, 0, -2, 0))
    show(world:raycast({3, 5, 0}, {0, -1, 0}))
    show(world:raycast(3, 5, 0, 0, -1, 0, 2))
    show(world:raycast(3, 5, 0, 0, -1, 0, nil, { ignore = ball }))
    show(world:raycast(3, 5, 0, 0, -1, 0, 10, { mask = 1 }))
    show(world:raycast(0, 5, 0, 0, 1, 0))
    print(#world:raycast_all(3, 5, 0, 0, -1, 0), world:raycast_all(3, 5, 0, 0, -1, 0)[1].object)
    show(world:shape_cast{ shape = feder.sphere(0.5), position = {3, 5, 0}, motion = {0, -10, 0} })
    print(#world:overlap{ shape = feder.sphere(0.5), position = {3, 1, 0} }, #world:overlap{ box = {{2, 0.5, -1}, {4, 2, 1}} }, #world:overlap{ box = {{8, 8, 8}, {9, 9, 9}} })
  )") == "nil\t0\nbody \"floor\"\t0.000 0.000 0.000  0.00 1.00 0.00  5.000\nbody \"ball\"\t3.000 2.000 0.000  0.00 "
         "1.00 0.00  3.000\nnil\tnil\n"
         "body \"floor\"\t3.000 0.000 0.000  0.00 1.00 0.00  5.000\nbody \"floor\"\t3.000 0.000 0.000  0.00 1.00 0.00  "
         "5.000\nnil\tnil\n"
         "2\tbody \"ball\"\nbody \"ball\"\t3.000 2.000 0.000  0.00 1.00 0.00  2.500\n1\t1\t0\n");
}

TEST_CASE("restore then run equals run, bit for bit", "[lua][world]") {
  CHECK(output_of(R"(
    world:body{ name = "floor", type = "static", shape = feder.plane() }
    local zone = world:region{ name = "zone", box = { {-9, 0, -9}, {9, 1, 9} } }
    for i = 1, 5 do world:body{ name = "b" .. i, shape = feder.box(1, 1, 1), position = { math.random() * 0.2, i * 1.2, 0 } } end
    local net = world:net{ name = "net", points = { {5, 3, 0}, {6, 3, 0}, {7, 3, 0} }, springs = { {1, 2}, {2, 3} }, pins = { 1 } }
    world:step(20)
    local s, dice = world:snapshot(), nil
    local doomed = world:find("b5")
    doomed:destroy()
    local late = world:body{ name = "late", shape = feder.sphere(1), position = {0, 20, 0} }
    world:step(3)
    world:restore(s)
    print(world:step_count(), late:alive(), doomed:alive(), doomed == world:find("b5"), zone:kind(), world:find("zone") == zone)
    world:step(30)
    local one = world:hash()
    dice = math.random()
    world:restore(s):step(30)
    print(world:hash() == one, math.random() == dice, #one, world:snapshot() ~= s)
    local again = world:body{ name = "again", shape = feder.sphere(1), position = {0, 20, 0} }
    print(again == late, late:alive(), again:alive(), late)
  )") == "20\tfalse\ttrue\ttrue\tregion\ttrue\ntrue\ttrue\t16\ttrue\nfalse\tfalse\ttrue\tbody \"late\"\n");
}

TEST_CASE("forces come back with a snapshot, whoever makes them", "[lua][world]") {
  // a kind, a formula, a function and one that is asked at every stage: each destroyed and switched off behind it
  for (const std::string make :
       {"kind = 'attractor', position = {5, 0, 0}, strength = 30", "each = '-20*x'",
        "each = function(x) return -20 * x, 0, 0 end", "each = function(x) return -20 * x, 0, 0 end, stages = true"}) {
    CAPTURE(make);
    CHECK(output_of(R"(
      local world = feder.world{ gravity = {0, 0, 0} }
      local net = world:net{ points = { {1, 0, 0}, {2, 0, 0} }, springs = { {1, 2} } }
      local force = world:force{ )" +
                    make + R"( }
      world:step(5)
      local s = world:snapshot()
      world:step(20)
      local hash = world:hash()
      local function again() return world:step(20):hash() == hash end
      force:destroy()
      local other = world:force{ each = function() return 0, 9, 0 end }
      world:step(3):restore(s)
      print(again(), force:alive(), other:alive(), force:enabled())
      world:restore(s)
      force:set_enabled(false)
      world:step(3):restore(s)
      print(again(), force:enabled())
    )") == "true\ttrue\tfalse\ttrue\ntrue\ttrue\n");
  }
}

TEST_CASE("a changed or foreign snapshot is refused", "[lua][world]") {
  const std::string make = "world:body{ shape = feder.sphere(1) } local s = world:snapshot() ";
  CHECK_THAT(error_of(make + "world:restore('x')"),
             Catch::Contains("test.lua:1: world:restore: expected a string that world:snapshot() gave"));
  CHECK_THAT(error_of(make + "world:restore(s:sub(1, -2))"),
             Catch::Contains("test.lua:1: world:restore: the snapshot is another world's, or has been changed"));
  CHECK_THAT(error_of(make + "world:restore(s:sub(1, 200) .. string.char((s:byte(201) + 1) % 256) .. s:sub(202))"),
             Catch::Contains("or has been changed"));
  CHECK_THAT(error_of(make + "feder.world{}:restore(s)"), Catch::Contains("the snapshot is another world's"));
  CHECK_THAT(error_of(make + "world:net{ points = {{0,0,0}} } world:restore(s)"),
             Catch::Contains("world:restore: snapshot"));
}

TEST_CASE("the same script gives the same hash", "[lua][world]") {
  const std::string text =
      "world:body{ type = 'static', shape = feder.plane() } for i = 1, 8 do world:body{ shape = feder.box(1, 1, 1), "
      "position = { math.random(), i * 1.1, math.random() } } end world:step(100) print(world:hash())";
  const std::string hash = output_of(text);
  CHECK(hash.size() == 17);
  CHECK(output_of(text) == hash);
  lua::HostOptions threads;
  threads.world = {{"threads", "2"}};
  CHECK(output_of(text, threads) == hash);
  lua::HostOptions seed;
  seed.has_seed = true, seed.seed = 9;
  CHECK(output_of(text, seed) != hash);
}

TEST_CASE("a world tells about itself", "[lua][world]") {
  CHECK(output_of(R"(
    local b = world:body{ shape = feder.sphere(1), mass = 2, position = {0, 10, 0}, velocity = {3, 0, 0} }
    local k, p, e = world:energy()
    print(("%.2f %.2f %.2f"):format(k, p, e), (world:momentum()), select(3, world:angular_momentum()))
    print(world:is_finite(), world:max_penetration(), type(world:residuals()), world:dimension(), ("%.4f"):format(select(2, world:gravity())))
    world:set_gravity(0, 0, 0):step(60)
    print(("%.3f %.3f"):format(b:position()), world:time(), b:mass(), b:type())
    local r = world:report()
    print(r.bodies, r.steps, #r.plan > 0, r.plan[1].name, r.systems[1].name ~= nil, r.bytes > 0)
  )") == "9.00 196.20 0.00\t6.0\t-60.0\ntrue\t0.0\ttable\t3\t-9.8100\n3.000 "
         "10.000\t1.0\t2.0\tdynamic\n1\t60\ttrue\tbegin\ttrue\ttrue\n");
}

TEST_CASE("joints by name, with the options that they have", "[lua][world]") {
  const std::string two =
      "local a = world:body{ shape = feder.sphere(1) } local b = world:body{ shape = feder.sphere(1), position = {3, "
      "0, 0} } ";
  CHECK(output_of(two + R"(
    local j = world:joint{ name = "link", type = "hinge", a = a, b = b, axis = {0, 0, 2}, limits = {-1, 1}, motor = { speed = 1, max_force = 10 } }
    print(j, j:type(), j:kind(), j:angle(), j:bodies() == a)
    j:set_limits(-0.5, 0.5):set_motor(0, 5)
    world:step(10)
    print(select("#", j:force()), select("#", j:torque()))
    local d = world:joint{ type = "distance", a = b, anchor = {3, 5, 0}, spring = { hertz = 2, damping_ratio = 0.5 } }
    print(("%.1f"):format(d:length()))
    j:destroy()
    print(j:alive(), a:alive())
  )") == "joint \"link\"\thinge\tjoint\t0.0\ttrue\n3\t3\n5.1\nfalse\ttrue\n");
  CHECK(error_of(two + "world:joint{ type = 'slider', a = a }")
            .find("test.lua:1: world:joint.type: this build has no joint type 'slider'; known: ") == 0);
  CHECK(error_of(two + "world:joint{ type = 'hing', a = a }")
            .find("test.lua:1: world:joint.type: unknown joint type 'hing'; did you mean 'hinge'?") == 0);
  CHECK(error_of(two + "world:joint{ type = 'ball' }") == "test.lua:1: world:joint.a: expected a body, got nil");
  CHECK(error_of(two + "world:joint{ type = 'ball', a = a, b = a }") ==
        "test.lua:1: world:joint.b: expected another body than a");
  CHECK(error_of(two + "world:joint{ type = 'ball', a = a, b = 'b' }") ==
        "test.lua:1: world:joint.b: expected a body, got 'b'");
  CHECK(error_of(two + "world:joint{ type = 'ball', a = a, b = b, motor = { speed = 1, max_force = 1 } }") ==
        "test.lua:1: world:joint.motor: a ball joint has no such thing");
  CHECK(error_of(two + "world:joint{ type = 'hinge', a = a, b = b, limits = {1, -1} }") ==
        "test.lua:1: world:joint.limits: expected lo at most hi, got {1, -1}");
  CHECK(error_of(two + "world:joint{ type = 'ball', a = a, b = b }:angle()") ==
        "test.lua:1: joint:angle: a ball joint has no angle");
  CHECK(error_of(two + "world:joint{ type = 'hinge', a = a, b = b, break_force = 0 }") ==
        "test.lua:1: world:joint.break_force: expected a number above 0, got 0");
}

TEST_CASE("nets count from one and check their numbers", "[lua][world]") {
  const std::string make =
      "local net = world:net{ points = { {0,0,0}, {1,0,0}, {2,0,0} }, masses = 0.5, springs = { {1, 2, stiffness = "
      "10}, {2, 3, rest_length = 0.5} } } ";
  CHECK(output_of(make + R"(
    print(net, net:count())
    print(net:point(2))
    print(net:set_point(2, 1, 1, 0):point(2))
    print(net:set_velocity(3, {0, 0, 7}):velocity(3))
    print(net:pin(1):pinned(1), net:unpin(1):pinned(1), net:mass(), net:mass(1))
    print(("%.3f %.3f %.3f"):format(net:strain(1), net:strain(2), net:strain()))
    print(net:add_spring(1, 3, { stiffness = 5 }), net:add_spring{ 1, 3, damping = 1 }, net:remove_spring(3):count())
    print(net:spring(2))
    local buf = net:positions()
    print(#buf, buf[4], net:positions(buf) == buf)
    local b = world:body{ shape = feder.sphere(0.1), position = {2, 0, 0} }
    net:attach(3, b, 0, 0, 0):detach(3)
    world:step(5)
    print(world:is_finite(), net:kind(), (net:destroy()), net:alive())
  )") == "net #0\t3\t2\n1.0\t0.0\t0.0\n1.0\t1.0\t0.0\n0.0\t0.0\t7.0\ntrue\tfalse\t1.5\t0.5\n0.414 1.828 "
         "1.828\n3\t4\t3\t4\n2\t3\t1000.0\t0.0\t0.5\n"
         "9\t1.0\ttrue\ntrue\tnet\tnil\tfalse\n");
  CHECK(error_of(make + "net:point(4)") == "test.lua:1: net:point: expected a point from 1 to 3, got 4");
  CHECK(error_of(make + "net:point(0)") == "test.lua:1: net:point: expected a point from 1 to 3, got 0");
  CHECK(error_of(make + "net:point(1.5)") == "test.lua:1: net:point: expected a point from 1 to 3, got 1.5");
  CHECK(error_of(make + "net:strain(9)") == "test.lua:1: net:strain: expected a spring from 1 to 2, got 9");
  CHECK(error_of(make + "net:positions(feder.buffer(8))") ==
        "test.lua:1: net:positions: expected a buffer of at least 9 numbers, got one of 8");
  CHECK(error_of(make + "net:add_spring(1, 1)") ==
        "test.lua:1: net:add_spring: expected two different points, got 1 twice");
  const auto net = [](const std::string& rest) {
    return error_of("world:net{ points = { {0,0,0}, {1,0,0}, {1,0,0} }, " + rest + " }");
  };
  CHECK(net("springs = { {1, 4} }") ==
        "test.lua:1: world:net.springs[1].j: expected a whole number from 1 to 3, got 4");
  CHECK(net("springs = { {2, 3} }") ==
        "test.lua:1: world:net.springs[1]: points 2 and 3 are at the same place; expected a rest_length, got nil");
  CHECK(net("springs = { {1, 2, stifness = 1} }") ==
        "test.lua:1: world:net.springs[1]: unknown option 'stifness'; did you mean 'stiffness'?");
  CHECK(net("springs = { {1, 2, stiffness = -1} }") ==
        "test.lua:1: world:net.springs[1].stiffness: expected a number of at least 0, got -1");
  CHECK(net("masses = {1, 2}") == "test.lua:1: world:net.masses: expected 3 numbers, one per point, got 2");
  CHECK(net("masses = {1, 0, 1}") == "test.lua:1: world:net.masses[2]: expected a number above 0, got 0");
  CHECK(net("integrator = 'eulr'").find("test.lua:1: world:net: unknown integrator 'eulr'; known: ") == 0);
  CHECK(net("radius = -1") == "test.lua:1: world:net.radius: expected a number of at least 0, got -1");
  CHECK(error_of("world:net{ points = {} }") == "test.lua:1: world:net.points: expected at least one point, got none");
  CHECK(error_of("world:net{}") == "test.lua:1: world:net.points: expected a list of {x, y, z} or a buffer, got nil");
}

TEST_CASE("a scripted force acts before each step", "[lua][world]") {
  CHECK(output_of(R"(
    local w = feder.world{ gravity = {0, 0, 0}, dt = 0.01 }
    local b = w:body{ shape = feder.sphere(1), mass = 2, tags = "pushed" }
    local other = w:body{ shape = feder.sphere(1), mass = 2, position = {9, 0, 0} }
    local net = w:net{ points = { {0, 9, 0} }, masses = 4 }
    local f = w:force{ name = "push", on = "pushed", each = function(x, y, z, vx, vy, vz, mass, t) return mass * 3 end }
    local g = w:force{ on = net, each = function(x, y, z, vx, vy, vz, mass, t) return 0, mass, 0 end }
    w:step(100)
    print(("%.3f"):format(b:velocity()), (other:velocity()), ("%.3f"):format(select(2, net:velocity(1))))
    f:destroy() g:set_enabled(false)
    w:step(100)
    print(("%.3f"):format(b:velocity()), f:alive(), g:enabled(), f)
  )") == "3.000\t0.0\t1.000\n3.000\tfalse\tfalse\tforce \"push\"\n");
  const Ran ran =
      run("world:body{ shape = feder.sphere(1) }\nworld:force{ each = function() return 0/0 end }\nworld:step(3) "
          "print('on')");
  CHECK(ran.output == "on\n");
  REQUIRE(ran.errors.size() == 1);
  CHECK(ran.errors[0].where == "test.lua:2");
  CHECK(ran.errors[0].message == "world:force.each: expected three finite numbers, got nan");
  CHECK(ran.errors[0].count == 3);
}

TEST_CASE("forces of the runtime by name", "[lua][world]") {
  CHECK(output_of(R"(
    local w = feder.world{ gravity = {0, 0, 0}, dt = 0.01 }
    local b = w:body{ shape = feder.sphere(1), mass = 2 }
    local f = w:force{ kind = "gravity", acceleration = {0, 2, 0}, on = b }
    w:step(100)
    print(("%.3f"):format(select(2, b:velocity())), f:kind(), f:destroy(), f:alive())
    w:step(50)
    print(("%.3f"):format(select(2, b:velocity())))
  )") == "2.000\tforce\tnil\tfalse\n2.000\n");
}

TEST_CASE("two dimensions", "[lua][world]") {
  CHECK(output_of(R"(
    local w = feder.world{ dimension = 2 }
    w:body{ type = "static", shape = feder.plane() }
    local b = w:body{ shape = feder.box(1, 1), position = {0, 0.5} }
    local c = w:body{ shape = feder.circle(0.5), position = {3, 0.5} }
    local p = w:body{ shape = feder.polygon{ {0, 0}, {1, 0}, {0, 1} }, position = {6, 1, 0} }
    w:step(60)
    local x, y, z = b:position()
    print(("%.2f %.2f %.2f"):format(x + 0.001, y, z), ("%.0f"):format(b:mass()), w:is_finite())
    print(b:set_velocity(1, 2):velocity())
    print(w:raycast(0, 5, 0, 0, -1, 0) == b)
  )") == "0.00 0.50 0.00\t1000\ttrue\n1.0\t2.0\t0.0\ntrue\n");
}

TEST_CASE("the density of still air and the bound on stretch are options", "[lua][world]") {
  CHECK(output_of(R"(
    local function fall(air)
      local w = feder.world{ air_density = air }
      local c = w:cloth{ size = {1, 1}, resolution = {9, 9} }
      local n = w:net{ points = { {0,0,0}, {1,0,0}, {1,0,1} }, faces = { {1,2,3} }, springs = { {1,2}, {2,3}, {3,1} } }
      w:step(60)
      return ("%.1f %.1f"):format(select(2, c:velocity(41)), select(2, n:velocity(1)))
    end
    print(fall(0), fall(nil) ~= fall(0), fall(nil) == fall(1.2))
    local function stretch(limit)
      local w = feder.world{}
      local c = w:cloth{ size = {3, 3}, resolution = {17, 17}, pins = {"top_left", "top_right"}, substeps = 1,
                         max_strain = limit }
      w:step(120)
      return c:strain()
    end
    print(stretch(nil) < 0.06, stretch(false) > 0.1)
  )") == "-9.8 -9.8\ttrue\ttrue\ntrue\ttrue\n");
}

TEST_CASE("an iteration limit that is reached is said once", "[lua][world]") {
  CHECK(output_of(R"(
    local w = feder.world{ rigid = { solver = "impulse", iterations = 1 } }
    w:body{ type = "static", shape = feder.plane() }
    for i = 1, 12 do w:body{ shape = feder.box(1,1,1), position = {0.1 * (i % 3), i * 0.98, 0} } end
    w:on("warning", function(e) print(e.code, e.message:match("iteration limit")) end)
    w:step(60)
  )") == "iteration_limit\titeration limit\n");
}

TEST_CASE("nothing passes a thin wall, and a bullet no moving one either", "[lua][world]") {
  CHECK(output_of(R"(
    for _, speed in ipairs{10, 100, 1000, 10000} do
      local w = feder.world{}
      w:body{ type = "static", shape = feder.box(0.02, 4, 4), position = {5, 0, 0} }
      local bullet = w:body{ shape = feder.sphere(0.05), bullet = true, velocity = {speed, 0, 0}, gravity_scale = 0 }
      local other = w:body{ shape = feder.sphere(0.05), position = {0, 1, 0}, velocity = {speed, 0, 0}, gravity_scale = 0 }
      local door = w:body{ shape = feder.box(0.02, 4, 4), mass = 1e6, position = {5, 10, 0}, gravity_scale = 0 }
      local third = w:body{ shape = feder.sphere(0.05), position = {0, 10, 0}, bullet = true, velocity = {speed, 0, 0}, gravity_scale = 0 }
      w:step(120)
      print(speed, (bullet:position()) < 4.96 and (other:position()) < 4.96, (third:position()) < (door:position()))
    end
  )") == "10\ttrue\ttrue\n100\ttrue\ttrue\n1000\ttrue\ttrue\n10000\ttrue\ttrue\n");
}
