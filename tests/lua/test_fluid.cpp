// Fluids from scripts: makers, questions, sources with their events, refused input.
#ifdef FEDER_HAS_FLUID
#include "support/script.h"

using namespace feder::test;

namespace {
const std::string kWater = "local water = world:fluid{ name = 'water', spacing = 0.1 } ";
}

TEST_CASE("a fluid is made, filled and asked", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    print(water:kind(), water:name(), water:count())
    print(water:fill{ box = { {0, 0, 0}, {0.5, 0.3, 0.4} } }, water:count())
    print(("%.3f %.3f"):format(water:mass()))
    local x = water:positions()
    print(#x, ("%.2f %.2f %.2f"):format(x[1], x[2], x[3]))
    print(water:fill{ shape = feder.sphere(0.1), position = {3, 0, 0} } > 0)
    print(water:fill{ points = { {5, 5, 5}, {6, 6, 6} }, velocity = {1, 0, 0} })
    local mean, most = water:density_error()
    print(mean < 0.01, most < 0.05)
    print(water:height_at(9, 9), math.abs(water:height_at(0.25, 0.2) - 0.3) < 0.05)
  )") == "fluid\twater\t0\n60\t60\n60.000 1.000\n180\t0.05 0.05 0.05\ntrue\n2\ntrue\ttrue\nnil\ttrue\n");
}

TEST_CASE("calm water sleeps, says so, and wakes", "[lua][fluid]") {
  CHECK(output_of(R"(
    for _, p in ipairs { { 0, 1, 0, 0 }, { 1, 0, 0, 0 }, { -1, 0, 0, -0.4 }, { 0, 0, 1, 0 }, { 0, 0, -1, -0.4 } } do
      world:body { type = "static", shape = feder.plane(table.unpack(p)) }
    end
    local water = world:fluid { name = "water", spacing = 0.1 }
    water:fill { box = { { 0, 0, 0 }, { 0.4, 0.3, 0.4 } } }
    world:on("sleep", function(e) print("sleeps", e.object:name()) end)
    world:on("wake", function(e) print("wakes", e.object:name(), e.cause) end)
    print(water:awake())
    world:step(480)
    print(water:awake())
    print(water:wake() == water, water:awake())
    world:step()
  )") == "true\nsleeps\twater\nfalse\ntrue\ttrue\nwakes\twater\tscript\n");
}

TEST_CASE("particles below kill_height are gone", "[lua][fluid]") {
  CHECK(output_of(R"(
    local rain = world:fluid{ spacing = 0.1, kill_height = -0.5 }
    rain:fill{ box = { {0, 0, 0}, {0.3, 0.2, 0.2} } }
    world:step(6)
    print(rain:count())
    world:step(60)
    print(rain:count(), rain:mass())
    print(select(2, pcall(world.fluid, world, { kill_height = "low" })))
  )") == "12\n0\t0.0\t1.0\ntest.lua:8: world:fluid.kill_height: expected a finite number, got 'low'\n");
}

TEST_CASE("forces act on fluids: kinds, formulas, functions, stages, tags", "[lua][fluid]") {
  CHECK(output_of(R"(
    world:set_gravity(0, 0, 0)
    local function drop(tags) -- the velocity that a step gives one
      local d = world:fluid{ spacing = 0.1, tags = tags }
      d:fill{ points = { {2, 0, 0} }, velocity = {0, 1, 0} }
      return d
    end
    local function show(name, d, f)
      world:step(1)
      local v = d:velocities()
      local function round(a) return math.floor(600 * a + 0.5) / 10 end
      print(name, round(v[1]), round(v[2] - 1), round(v[3]))
      f:destroy()
      d:destroy()
    end
    for _, force in ipairs{
      { kind = "gravity", acceleration = {3, 0, 0} },
      { kind = "drag", linear = 2 },
      { kind = "wind", velocity = {10, 1, 0} },
      { kind = "attractor", strength = 8 },
      { kind = "spring", stiffness = 4 },
      { kind = "buoyancy", height = 9 },
      { each = { "m*5", "0", "-m" } },
      { each = "k*x", params = { k = 2 } },
      { each = function(x, y, z, vx, vy, vz, m, t) return m * x, 0, m * vy end },
      { each = function(x, y, z, vx, vy, vz, m, t) return m * x, 0, m * vy end, stages = true },
    } do
      local d = drop()
      force.on = d
      show(force.kind or type(force.each), d, world:force(force))
    end
    local d, dry = drop("wet"), drop()
    local f = world:force{ on = "wet", each = "m" }
    show("tag", d, f)
    print(dry:velocities()[1])
    print(select(2, pcall(world.force, world, { on = dry, points = {1}, kind = "gravity" })))
  )") == "gravity\t3.0\t0.0\t0.0\ndrag\t0.0\t-2.0\t0.0\nwind\t0.6\t0.0\t0.0\nattractor\t-2.0\t0.0\t0.0\n"
         "spring\t-8.0\t0.0\t0.0\nbuoyancy\t0.0\t9.8\t0.0\ntable\t5.0\t0.0\t-1.0\nstring\t4.0\t0.0\t0.0\n"
         "function\t2.0\t0.0\t1.0\nfunction\t2.0\t0.0\t1.0\ntag\t1.0\t0.0\t0.0\n0.0\n"
         "test.lua:36: world:force.points: expected on = a net, whose points these are\n");
}

TEST_CASE("fluid and a net tell of their contact", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    world:set_gravity(0, 0, 0)
    local net = world:net{ name = "net", points = { {0,0,0}, {1,0,0}, {1,0,1}, {0,0,1} }, faces = { {1,2,3,4} },
      pins = {1,2,3,4} }
    water:fill{ points = { {0.5, 0.3, 0.4} }, velocity = {0, -2, 0} }
    world:on("contact_begin", function(e) print("begin", e.a:name(), e.b:name(), e.count, e.ny > 0.9) end)
    net:on("hit", function(e) print("hit", e.other:name(), math.abs(e.speed - 2) < 0.01, e.impulse > 0) end)
    world:on("contact_end", function(e) print("end", e.a:name(), e.b:name()) end)
    world:step(30)
  )") == "begin\tnet\twater\t1\ttrue\nhit\twater\ttrue\ttrue\nend\tnet\twater\n");
}

TEST_CASE("velocities come from a function or a buffer", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    water:fill{ box = { {0, 0, 0}, {0.2, 0.1, 0.1} } }
    water:set_velocities(function(x, y, z, i) return 2, 0, i end)
    local v = water:velocities()
    print(v[1], v[3], v[6])
    v[1] = 7
    water:set_velocities(v)
    print(water:velocities()[1])
    print(pcall(water.set_velocities, water, function() return 0/0 end))
    print(water:velocities()[1])
  )") == "2.0\t1.0\t2.0\n7.0\nfalse\ttest.lua:9: fluid:set_velocities: velocity of particle 1: expected a finite "
         "number, got nan\n7.0\n");
}

TEST_CASE("emitters stop, start and end; drains count", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    world:set_gravity(0, 0, 0)
    local hose = water:emitter{ name = "hose", direction = {1, 0, 0}, speed = 2, radius = 0.15, rate = 64, limit = 12 }
    local sink = water:drain{ name = "sink", box = { {1, -1, -1}, {9, 1, 1} } }
    local drained = 0
    world:on("emitter_done", function(e) print(e.object:name(), e.other:name(), e.count, world:step_count()) end)
    water:on("drained", function(e) drained = drained + e.count end)
    hose:on("emitter_done", function(e) print("own", e.count) end)
    world:step(6)
    print(hose:count(), hose:running())
    hose:stop()
    world:step(10)
    print(hose:count(), hose:running())
    hose:start()
    world:step(60)
    print(hose:count(), hose:running(), drained, sink:count(), water:count())
    water:destroy()
    print(hose:alive(), sink:alive(), hose:kind())
    print(select(2, pcall(hose.stop, hose)))
  )") == "7\ttrue\n7\tfalse\nhose\twater\t12\t21\nown\t12\n12\tfalse\t12\t12\t0\nfalse\tfalse\temitter\n"
         "test.lua:19: emitter:stop: emitter \"hose\" was destroyed at test.lua:17\n");
}

TEST_CASE("emitters and drains ride on bodies", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    world:set_gravity(0, 0, 0)
    local cart = world:body{ name = "cart", type = "kinematic", shape = feder.box(0.1, 0.1, 0.1), velocity = {6, 0, 0} }
    local hose = water:emitter{ name = "hose", body = cart, position = {0, 1, 0}, direction = {0, 1, 0}, speed = 3,
      radius = 0 }
    local mouth = water:drain{ body = cart, box = { {-0.2, 1.5, -0.2}, {0.2, 2, 0.2} } }
    world:on("warning", function(e) print(e.code, e.object:name(), e.message) end)
    world:step(30)
    local v, x = water:velocities(), water:positions()
    print(("%.2f %.2f %.2f"):format(v[1], v[2], x[1] - cart:position()))
    print(hose:count() > 12, mouth:count() > 5)
    cart:destroy()
    world:step(2)
    print(hose:running())
    print(select(2, pcall(water.emitter, water, { body = cart })))
    print(select(2, pcall(water.drain, water, { body = water, box = { {0, 0, 0}, {1, 1, 1} } })))
  )") == "6.00 3.00 0.00\ntrue\ttrue\n"
         "source_lost\those\temitter \"hose\" stops: body \"cart\", which it rode on, was destroyed at test.lua:12; "
         "drain #3 stops: body \"cart\", which it rode on, was destroyed at test.lua:12; destroy it as well, or make "
         "another one\nfalse\n"
         "test.lua:15: fluid:emitter.body: body \"cart\" was destroyed at test.lua:12\n"
         "test.lua:16: fluid:drain.body: expected a body, got fluid \"water\"\n");
}

TEST_CASE("a region says when the first particle comes and the last has left", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    world:set_gravity(0, 0, 0)
    local gate = world:region{ name = "gate", box = { {1, -1, -1}, {2, 1, 1} } }
    water:fill{ box = { {0, 0, 0}, {0.4, 0.1, 0.1} }, velocity = {3, 0, 0} }
    world:on("sensor_enter", function(e) print("in", e.sensor:name(), e.other:name(), e.count) end)
    world:on("sensor_leave", { sensor = gate }, function(e) print("out", e.other:kind(), e.count) end)
    world:step(60)
  )") == "in\tgate\twater\t1\nout\tfluid\t0\n");
}

TEST_CASE("a fluid is sampled at a point, and what flows through a box is weighed", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    world:set_gravity(0, 0, 0)
    water:fill{ box = { {0, 0, 0}, {1, 1, 1} }, velocity = {2, 0, 0} }
    water:set_velocities(function(x, y) return 2, 3 * x, 0 end)
    local s = water:sample(0.5, 0.5, 0.5)
    print(math.abs(s.density - 1000) < 30, #s.velocity, #s.velocity_gradient, #s.velocity_gradient[2])
    print(("%.1f %.1f %.2f"):format(s.velocity[1], s.velocity[2], s.velocity_gradient[2][1]))
    print(type(s.pressure), #s.pressure_gradient, #s.density_gradient)
    local none = water:sample{ 9, 9, 9 }
    print(none.density, none.pressure, none.velocity[1], none.velocity_gradient[3][3])
    local f = water:flux{ box = { {0.4, -1, -1}, {0.6, 2, 2} } }
    print(("%.0f %.0f %.0f %.1f"):format(f.mass, f.x, f.momentum[1], f.velocity[1]))
    print(water:clumping(), world:residuals()["fluid.clumping"])
    print(select(2, pcall(water.flux, water, { box = { {1, 0, 0}, {0, 1, 1} } })))
    print(select(2, pcall(water.flux, water, {})))
    print(select(2, pcall(water.sample, water, 0, 0 / 0, 0)))
  )") == "true\t3\t3\t3\n2.0 1.5 3.00\nnumber\t3\t3\n0.0\t0.0\t0.0\t0.0\n200 2000 400 2.0\n0.0\t0.0\n"
         "test.lua:14: fluid:flux.box: expected the second corner above the first, got 1 and 0 along x\n"
         "test.lua:15: fluid:flux.box: expected {min, max}, got nothing\n"
         "test.lua:16: fluid:sample.y: expected a finite number, got nan\n");
}

TEST_CASE("mistakes name what was expected, and leave the world as it was", "[lua][fluid]") {
  CHECK(error_of("world:fluid{ spacing = 0 }").find("world:fluid.spacing: expected a number above 0, got 0") !=
        std::string::npos);
  CHECK(error_of("world:fluid{ spacign = 1 }").find("did you mean 'spacing'?") != std::string::npos);
  CHECK(error_of("world:fluid{ solver = 'sph' }").find("known: dfsph, pbf, wcsph") != std::string::npos);
  CHECK(error_of("world:fluid{ solver = 'dfsph', tolerance = 0 }").find("world:fluid.tolerance: expected") !=
        std::string::npos);
  CHECK(error_of("world:fluid{ wall_slip = 'some' }").find("world:fluid.wall_slip: ") != std::string::npos);
  CHECK(error_of("world:fluid{ wall_slip = 'some' }").find("none, free") != std::string::npos);
  for (const char* wrong :
       {"surface_tension = -1", "surface_tension = 1, contact_angle = 200", "contact_angle = 60",
        "surface_tension = 1, contact_angle = 60, adhesion = 1", "adhesion = -1", "surface_model = 'soap'",
        "friction = -1", "vorticity = -1", "kernels = 'cubic'", "kernel = 'cubic', kernels = { viscosity = 'cubic' }",
        "kernels = { density = 'cubic', pressure = 'wendland' }", "surface_model = 'color_field', solver = 'wcsph'"})
    CHECK(error_of(std::string("world:fluid{ ") + wrong + " }").find("expected") != std::string::npos);
  for (const char* wrong : {"viscosity = 'gauss'", "force = 'cubic'"})
    CHECK(error_of(std::string("world:fluid{ kernels = { ") + wrong + " } }").find("known: ") != std::string::npos);
  CHECK(output_of("print(world:fluid{ wall_slip = 'free', viscosity = 1 }:kind())") == "fluid\n");
  CHECK(error_of(kWater + "\nwater:fill{ box = { {0, 0, 0}, {1, 0.05, 1} } }") ==
        "test.lua:2: fluid:fill: fluid: fill: the shape is 0.05 m wide along y, narrower than the spacing of 0.1 m: "
        "take a smaller "
        "spacing or a larger shape");
  CHECK(error_of("world:fluid{ kernel = 'gauss' }").find("known: wendland, cubic, poly6_spiky") != std::string::npos);
  CHECK(error_of("world:fluid{ neighbors = 'octree' }").find("known: grid") != std::string::npos);
  CHECK(error_of("world:fluid{ viscosity = 1, kinematic_viscosity = 1 }").find("got both") != std::string::npos);
  CHECK(error_of(kWater + "water:fill{}").find("expected box = {min, max} or shape =, got neither") !=
        std::string::npos);
  CHECK(error_of(kWater + "water:emitter{ rate = 1e9 }").find("particles per second") != std::string::npos);
  CHECK(output_of("pcall(world.fluid, world, { spacing = -1 }) print(world:report().fluids)") == "0\n");
}

TEST_CASE("kernels may be named by force", "[lua][fluid]") {
  CHECK(output_of(R"(
    local function hash(options)
      local world = feder.world {}
      options.spacing, options.viscosity = 0.1, 5
      local fluid = world:fluid(options)
      fluid:fill { box = { { 0, 0, 0 }, { 0.5, 0.5, 0.5 } } }
      fluid:set_velocities(function(x, y, z) return y, 0, 0 end)
      for k = 1, 5 do world:step() end
      return world:hash()
    end
    local cubic, wendland = hash { kernel = "cubic" }, hash {}
    print(cubic == hash { kernels = { density = "cubic" } }, wendland == hash { kernels = { viscosity = "wendland" } })
    print(hash { kernel = "poly6_spiky" } ==
      hash { kernels = { density = "poly6", pressure = "spiky", viscosity = "viscosity" } })
    local mixed = hash { kernels = { viscosity = "cubic" } }
    print(mixed == wendland, mixed == cubic)
  )") == "true\ttrue\ntrue\nfalse\tfalse\n");
}

TEST_CASE("fluids that may touch agree on how they are solved, and on the tension between them", "[lua][fluid]") {
  CHECK(
      output_of(kWater + R"(
    local oil = world:fluid{ name = 'oil', spacing = 0.1, density = 900, color = 'gold' }
    local other = world:fluid{ name = 'other', spacing = 0.1, group = 2, mask = 2, solver = 'pbf' }
    world:interface{ water, oil, tension = 0.05 }
    local function says(f) print((select(2, pcall(f)))) end
    says(function() world:fluid{ name = 'wine', spacing = 0.1, solver = 'pbf' } end)
    says(function() world:interface{ water, water, tension = 1 } end)
    says(function() world:interface{ water, other, tension = 1 } end)
    says(function() world:interface{ water, oil, tension = -1 } end)
    says(function() world:interface{ water, oil } end)
    says(function() world:interface{ water, 3, tension = 1 } end)
    says(function() world:fluid{ negative_pressure = 2 } end)
  )") ==
      "test.lua:6: world:fluid: solver: expected \"dfsph\", that of fluid \"water\", got \"pbf\" for 'wine': fluids "
      "that "
      "may touch are solved as one; give both one solver, or groups and masks that keep them apart\n"
      "test.lua:7: world:interface: expected two fluids, got fluid \"water\" twice\n"
      "test.lua:8: world:interface: expected fluids that may touch, but groups and masks of fluid \"water\" and fluid "
      "\"other\" keep them apart\n"
      "test.lua:9: world:interface.tension: expected a number of at least 0, got -1\n"
      "test.lua:10: world:interface.tension: expected a number, 0 or more, got nothing\n"
      "test.lua:11: world:interface[2]: expected a fluid, got 3\n"
      "test.lua:12: world:fluid.negative_pressure: expected a number from 0 to 1, got 2\n");
}

TEST_CASE("the surface of a fluid comes as triangles", "[lua][fluid]") {
  CHECK(output_of(kWater + R"(
    water:fill{ box = { {0, 0, 0}, {0.6, 0.6, 0.6} } }
    local buffer, count = water:surface()
    print(#buffer == 9 * count, count > 300)
    local volume = 0
    for t = 0, count - 1 do
      local c = {}
      for k = 1, 9 do c[k] = buffer[9 * t + k] end
      volume = volume + (c[1] * (c[5] * c[9] - c[6] * c[8]) + c[2] * (c[6] * c[7] - c[4] * c[9]) + c[3] * (c[4] * c[8] - c[5] * c[7])) / 6
    end
    print(math.abs(volume / 0.6 ^ 3 - 1) < 0.08)
  )") == "true\ttrue\ntrue\n");
}

TEST_CASE("a body falls into water and is woken by it", "[lua][fluid]") {
  CHECK(output_of(R"(
    world:body{ type = 'static', shape = feder.plane() }
    local stone = world:body{ name = 'stone', shape = feder.box(0.3, 0.3, 0.3), position = {0, 0.15, 0}, sleeping = true }
    local water = world:fluid{ spacing = 0.1 }
    water:fill{ box = { {-0.3, 0.5, -0.3}, {0.3, 0.9, 0.3} } }
    local cause
    world:on("wake", function(e) cause = cause or e.cause .. " " .. e.other:kind() end)
    world:step(60)
    print(cause, world:is_finite())
  )") == "fluid fluid\ttrue\n");
}

TEST_CASE("the library of fluids", "[lua][fluid]") {
  feder::lua::HostOptions options;
  options.library_roots = {std::string(FEDER_SOURCE_DIR) + "/scripts"};
  CHECK(output_of(R"(
    local fluid = require "feder.fluid"
    local honey = world:fluid(fluid.of("honey", { spacing = 0.1 }))
    print(honey:kind(), select(2, pcall(function() return (fluid.of("hony")) end)))
  )",
                  options) ==
        "fluid\ttest.lua:4: fluid.of: unknown material 'hony'; known: alcohol, honey, mercury, oil, water\n");
}
#endif
