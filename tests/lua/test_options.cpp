// The promised messages: what was expected, what came, and where.
#include "state/bodies.h"
#include "support/script.h"

using namespace feder::test;

namespace {
struct Mistake {
  const char* text;
  const char* message;
};
}  // namespace

TEST_CASE("a mistake in an options table says file, line, expected and given", "[lua][options]") {
  const Mistake mistakes[] = {
      {"world:body{ shape = feder.box(1,1,1), frction = 1 }",
       "test.lua:1: world:body: unknown option 'frction'; did you mean 'friction'?"},
      {"\nworld:body{ shape = feder.box(1,1,1), density = -5 }",
       "test.lua:2: world:body.density: expected a number above 0, got -5"},
      {"world:body{ shape = feder.box(1,1,1), density = '5' }",
       "test.lua:1: world:body.density: expected a number above 0, got '5'"},
      {"world:body{ shape = feder.box(1,1,1), density = 1e-60 }",
       // 0 in the float build
       sizeof(feder::Real) == 4
           ? "test.lua:1: world:body.density: expected a number above 0, got 1e-60"
           : "test.lua:1: world:body.mass: expected from 1e-9 to 1e14 kg (rock from 0.1 mm to 3 km in size; mind the "
             "density), got 1e-60"},
      {"world:body{ shape = feder.box(1,1,1), mass = 0/0 }",
       "test.lua:1: world:body.mass: expected a finite number, got nan"},
      {"world:body{ shape = feder.box(1,1,1), mass = -1 }",
       "test.lua:1: world:body.mass: expected a number above 0, got -1"},
      {"world:body{ shape = feder.box(1,1,1), mass = 0 }",
       "test.lua:1: world:body.mass: expected a number above 0, got 0"},
      {"world:body{ shape = feder.box(1,1,1), position = {0, 0/0, 0} }",
       "test.lua:1: world:body.position.y: expected a finite number, got nan"},
      {"world:body{ shape = feder.box(1,1,1), position = {0, 1/0, 0} }",
       "test.lua:1: world:body.position.y: expected a finite number, got inf"},
      {"world:body{ shape = feder.box(1,1,1), position = {0, 1e300, 0} }",
       "test.lua:1: world:body.position.y: expected a finite number, got 1e+300"},
      {"world:body{ shape = feder.box(1,1,1), position = {0, '1', 0} }",
       "test.lua:1: world:body.position.y: expected a finite number, got '1'"},
      {"world:body{ shape = feder.box(1,1,1), position = {0, 1} }",
       "test.lua:1: world:body.position: expected {x, y, z}, got a table of 2 values"},
      {"world:body{ shape = feder.box(1,1,1), position = 3 }",
       "test.lua:1: world:body.position: expected {x, y, z}, got 3"},
      {"world:body{ shape = 1 }", "test.lua:1: world:body.shape: expected a shape (feder.box(1, 1, 1) ...), got 1"},
      {"world:body{}", "test.lua:1: world:body.shape: expected a shape (feder.box(1, 1, 1) ...), got nil"},
      {"world:body()", "test.lua:1: world:body: expected a table of options { ... }, got nil"},
      {"world:body{ feder.box(1,1,1) }", "world:body.shape: expected a shape"},
      {"world:body{ shape = feder.box(1,1,1), 5 }", "test.lua:1: world:body: expected options by name, got the key 1"},
      {"world:body{ shape = feder.box(1,1,1), type = 'dynamik' }",
       "test.lua:1: world:body.type: expected one of static, kinematic, dynamic, got 'dynamik'"},
      {"world:body{ shape = feder.box(1,1,1), lock = {'x', 'q'} }",
       "test.lua:1: world:body.lock: expected some of x, y, z, rx, ry, rz, got 'q'"},
      {"world:body{ shape = feder.box(1,1,1), restitution = 2 }",
       "test.lua:1: world:body.restitution: expected a number from 0 to 1, got 2"},
      {"world:body{ shape = feder.box(1,1,1), friction = -1 }",
       "test.lua:1: world:body.friction: expected a number of at least 0, got -1"},
      {"world:body{ shape = feder.box(1,1,1), gravity_scale = 1e7 }",
       "test.lua:1: world:body.gravity_scale: expected a number from -1000000 to 1000000, got 10000000"},
      {"world:body{ shape = feder.box(1,1,1), friction = {static=1, dynamc=1} }",
       "test.lua:1: world:body.friction: unknown option 'dynamc'; did you mean 'dynamic'?"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {axis={0,1,0}} }",
       "test.lua:1: world:body.rotation: expected {x, y, z, w}, {axis =, angle =} or {euler = {..}}"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {axis={0,0,0}, angle=1} }",
       "test.lua:1: world:body.rotation.axis: expected a direction, got {0, 0, 0}"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {0,0,0,0} }",
       "test.lua:1: world:body.rotation: expected a quaternion of length 1, got one of length 0"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {0, 0, 15} }",
       "test.lua:1: world:body.rotation: expected {x, y, z, w}, {axis =, angle =} or {euler = {..}}, got a table of 3 "
       "values"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {0, 0, 15, 0} }",
       "test.lua:1: world:body.rotation: expected a quaternion of length 1, got one of length 15"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {0, 0, 0, 1.002} }",
       "test.lua:1: world:body.rotation: expected a quaternion of length 1, got one of length 1.002"},
      {"world:body{ shape = feder.box(1,1,1) }:set_rotation(0, 0, 0, 0.99)",
       "test.lua:1: body:set_rotation: expected a quaternion of length 1, got one of length 0.99"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {} }", "or {euler = {..}}, got an empty table"},
      {"world:body{ shape = feder.box(1,1,1), position = {x = 1, y = 2} }",
       "test.lua:1: world:body.position: expected {x, y, z}, got a table with the keys x, y"},
      {"feder.box{ w = 1, h = 1, d = 1 }",
       "test.lua:1: feder.box: expected {x, y, z}, got a table with the keys d, h, w"},
      {"feder.ball(1)", "test.lua:1: feder has no 'ball'; did you mean 'sphere'?"},
      {"feder.Box(1, 1, 1)", "test.lua:1: feder has no 'Box'; did you mean 'box'?"},
      {"feder.sfere(1)", "test.lua:1: feder has no 'sfere'; did you mean 'sphere'?"},
      {"world:body{ shape = feder.box(1,1,1) }:get_position()",
       "test.lua:1: a body has no method 'get_position'; did you mean 'position'?"},
      {"world:body{ shape = feder.box(1,1,1) }:getPosition()",
       "test.lua:1: a body has no method 'getPosition'; did you mean 'position'?"},
      {"world:body{ shape = feder.box(1,1,1) }:setPosition(0, 0, 0)",
       "test.lua:1: a body has no method 'setPosition'; did you mean 'set_position'?"},
      {"world:body{ shape = feder.box(1,1,1) }:AddForce(0, 0, 0)", "did you mean 'apply_force'?"},
      {"world:on('collision', print)",
       "test.lua:1: world:on: unknown event 'collision'; did you mean 'contact_begin'?"},
      {"world:body{ shape = feder.box(1,1,1), sensor = 'al' }",
       "test.lua:1: world:body.sensor: expected true, false or \"all\", got 'al'"},
      {"feder.scene{ dimension = 2, build = print }",
       "test.lua:1: feder.scene: 'dimension' belongs into `world = { ... }`"},
      {"feder.scene{ rigid = {}, build = print }",
       "test.lua:1: feder.scene: 'rigid' belongs into `world = { rigid = { ... } }`"},
      {"world:body{ shape = feder.box(1,1,1), static = 1 }",
       "test.lua:1: world:body: 'static' belongs into `friction = { ... }`"},
      {"world:body{ shape = feder.box(1,1,1), rotation = {euler={0,0,0}, order='xxw'} }",
       "test.lua:1: world:body.rotation.order: expected three of the letters x, y, z, got 'xxw'"},
      {"world:body{ shape = feder.box(1,1,1), group = 1.5 }",
       "test.lua:1: world:body.group: expected a whole number from 0 to 4294967295, got 1.5"},
      {"world:body{ shape = feder.box(1,1,1), bullet = 1 }",
       "test.lua:1: world:body.bullet: expected true or false, got 1"},
      {"world:body{ shape = feder.box(1,1,1), material = 'ice' }",
       "test.lua:1: world:body.material: unknown material 'ice'; the world has no materials"},
      {"world:body{ shape = feder.box(1,1,1), density = 1, mass = 1 }",
       "test.lua:1: world:body.mass: expected density or mass, got both"},
      {"feder.box(1, -1, 1)", "test.lua:1: feder.box.height: expected a number"},
      {"feder.box(1, 1, 1, 1)", "test.lua:1: feder.box: expected at most 3 arguments, got 4"},
      {"feder.sphere(0/0)", "test.lua:1: feder.sphere.radius: expected a finite number, got nan"},
      {"feder.sphere('1')", "test.lua:1: feder.sphere.radius: expected a number"},
      {"feder.heightfield{}", "test.lua:1: feder.heightfield: this build has no such shape"},
      {"feder.hull{ {0,0,0}, {1,0,0} }", "test.lua:1: feder.hull:"},
      {"feder.mesh({{0,0,0},{1,0,0},{0,1,0}}, {{1,2,4}})",
       "test.lua:1: feder.mesh.triangles[1]: expected a whole number from 1 to 3, got 4"},
      {"feder.plane(0, 0, 0)", "test.lua:1: feder.plane: expected a normal of a direction, got one of length 0"},
      {"feder.world{ dt = 0 }", "test.lua:1: feder.world.dt: expected a number above 0"},
      {"feder.world{ dt = 2 }", "test.lua:1: feder.world.dt: expected a number above 0 and at most 1, got 2"},
      {"feder.world{ substeps = 0 }",
       "test.lua:1: feder.world.substeps: expected a whole number from 1 to 1000, got 0"},
      {"feder.world{ gravty = {0,0,0} }", "test.lua:1: feder.world: unknown option 'gravty'; did you mean 'gravity'?"},
      {"feder.world{ rigid = { solver = 'soft_stap' } }", "test.lua:1: feder.world"},
      {"feder.world{ rigid = { solvr = 'soft_step' } }", "did you mean 'solver'?"},
      {"feder.world{ broad_phase = 'treee' }", "unknown broad phase 'treee'; known: "},
      {"feder.world{ dimension = 4 }", "test.lua:1: feder.world.dimension: expected a whole number from 2 to 3, got 4"},
      {"feder.world{ air_density = -1 }",
       "test.lua:1: feder.world.air_density: expected a number from 0 to 1000000, got -1"},
      {"world:cloth{ size = {1, 1}, max_strain = true }",
       "test.lua:1: world:cloth.max_strain: expected a number above 0 or false, got true"},
      {"world:cloth{ size = {1, 1}, max_strain = 0 }",
       "test.lua:1: world:cloth.max_strain: expected a number above 0, got 0"},
      {"world:cloth{ sise = {1, 1} }", "test.lua:1: world:cloth: unknown option 'sise'; did you mean 'size'?"},
#ifndef FEDER_HAS_FLUID
      {"world:fluid{}", "test.lua:1: world:fluid: this build leaves out the module 'fluid'"},
      {"require 'feder.fluid'", "test.lua:1: require: this build leaves out the module 'feder.fluid'"},
#endif
      {"world:bdy{}", "test.lua:1: a world has no method 'bdy'; did you mean 'body'?"},
      {"world.step(1)", "test.lua:1: world:step: expected a world before the ':', got 1"},
      {"world:raycast(0, 1, 0, 0, 0, 0)", "test.lua:1: world:raycast: expected a direction, got 0, 0, 0"},
      {"world:force{ kind = 'windd' }", "test.lua:1: world:force: unknown force kind 'windd'; known: "},
      {"world:force{ kind = 'wind', each = print }", "test.lua:1: world:force: expected either kind"},
      {"world:force{ kind = 'drag', liner = 1 }",
       "test.lua:1: world:force: unknown option 'liner'; did you mean 'linear'?"},
      {"world:force{ kind = 'drag', linear = -1 }", "test.lua:1: world:force.linear: expected a number from 0"},
      {"world:on('contact_begn', print)",
       "test.lua:1: world:on: unknown event 'contact_begn'; did you mean 'contact_begin'?"},
      {"world:on('hit', { min_spead = 1 }, print)",
       "test.lua:1: world:on(\"hit\"): unknown option 'min_spead'; did you mean 'min_speed'?"},
      {"world:on('hit')", "test.lua:1: world:on: expected a function as handler, got nil"},
      {"world:after(-1, print)", "test.lua:1: world:after: expected a number of at least 0, got -1"},
      {"world:every(0, print)", "test.lua:1: world:every: expected a number above 0, got 0"},
      {"feder.wait(1)", "test.lua:1: feder.wait: works inside world:task"},
      {"feder.buffer(1e12)", "test.lua:1: feder.buffer: expected a whole number from 1 to 134217728, got 1e+12"},
      {"feder.buffer(3)[4] = 1", "test.lua:1: buffer: expected an index from 1 to 3, got 4"},
      {"print(feder.buffer(3)[0/0])", "test.lua:1: buffer: expected an index from 1 to 3, got nan"},
      {"world:region{}", "test.lua:1: world:region: expected box = {min, max} or shape =, got neither"},
      {"world:region{ box = {{0,0,0},{1,0,1}} }",
       "test.lua:1: world:region.box: expected the second corner above the first, got 0 and 0 along y"},
  };
  for (const Mistake& m : mistakes) {
    const Ran ran = run(m.text);
    CAPTURE(m.text);
    if (ran.error.find("this build leaves out") == std::string::npos) CHECK_THAT(ran.error, Catch::Contains(m.message));
    CHECK(ran.error.find('\n') == std::string::npos);
    CHECK(ran.error.rfind("test.lua:", 0) == 0);
  }
}

TEST_CASE("a mistake in how a mesh finds its triangles names what there is", "[lua][options]") {
  const Mistake mistakes[] = {
      {"{ index = 'octre' }", "feder.mesh: unknown mesh index 'octre'; known: bvh, grid, kd_tree, octree, bsp"},
      {"{ index = 'BVH' }", "feder.mesh: unknown mesh index 'BVH'; known: bvh, grid, kd_tree, octree, bsp"},
      {"{ index = 3 }", "feder.mesh.index: expected a string, got 3"},
      {"{ index = { 'grid' } }", "feder.mesh.index: expected a string, got a table"},
      {"{ index = 'grid', volume = 'obb' }",
       "feder.mesh: volume and build are those of index = \"bvh\", got index = \"grid\""},
      {"{ index = 'bsp', build = 'sah' }",
       "feder.mesh: volume and build are those of index = \"bvh\", got index = \"bsp\""},
      {"{ volume = 'sphre' }",
       "feder.mesh: unknown bounding volume 'sphre'; known: aabb, sphere, obb, kdop14, kdop18, kdop26, hull"},
      {"{ index = 'bvh', volume = 'kdop16' }",
       "feder.mesh: unknown bounding volume 'kdop16'; known: aabb, sphere, obb, kdop14, kdop18, kdop26, hull"},
      {"{ volume = false }", "feder.mesh.volume: expected a string, got false"},
      {"{ build = 'shah' }", "feder.mesh: unknown build 'shah'; known: top_down, sah, bottom_up, insertion, morton"},
      {"{ volume = 'obb', build = 'median' }",
       "feder.mesh: unknown build 'median'; known: top_down, sah, bottom_up, insertion, morton"},
      {"{ build = print }", "feder.mesh.build: expected a string, got a function"},
      {"{ leaf = 0 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got 0"},
      {"{ leaf = -1 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got -1"},
      {"{ leaf = 65 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got 65"},
      {"{ leaf = 1e9 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got 1000000000"},
      {"{ leaf = 2.5 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got 2.5"},
      {"{ leaf = 0/0 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got nan"},
      {"{ leaf = 1/0 }", "feder.mesh.leaf: expected a whole number from 1 to 64, got inf"},
      {"{ leaf = '4' }", "feder.mesh.leaf: expected a whole number from 1 to 64, got '4'"},
      {"{ indx = 'bvh' }", "feder.mesh: unknown option 'indx'; did you mean 'index'?"},
      {"{ leaves = 4 }", "feder.mesh: unknown option 'leaves'; did you mean 'leaf'?"},
      {"{ 'bvh' }", "feder.mesh: expected options by name, got the key 1"},
      {"'bvh'", "feder.mesh: expected a table of options { ... }, got 'bvh'"},
      {"{ leaf = 2 }, 4", "feder.mesh: expected at most 3 arguments, got 4"},
  };
  for (const Mistake& m : mistakes) {
    CAPTURE(m.text);
    CHECK(run(std::string("feder.mesh({{0,0,0},{1,0,0},{0,0,1}}, {{1,3,2}}, ") + m.text + ")").error ==
          std::string("test.lua:1: ") + m.message);
  }
  CHECK(error_of("world:body{ shape = feder.sphere(1), transparency = 2 }") ==
        "test.lua:1: world:body.transparency: expected a number from 0 to 1, got 2");
}

TEST_CASE("a quaternion may be as long as a few digits make it", "[lua][options]") {
  CHECK(output_of(R"(
    local x, y, z, w = world:body{ shape = feder.sphere(1), rotation = {0, 0.7071, 0, 0.7071} }:rotation()
    print(math.abs(x * x + y * y + z * z + w * w - 1) < 1e-6)
  )") == "true\n");
}

TEST_CASE("a method shows how it is called", "[lua][options]") {
  CHECK(output_of(R"(
    local b = world:body{ shape = feder.sphere(1) }
    print(b.position) print(b.alive) print(world.time) print(feder.deg) print(tostring(feder.sphere):sub(1, 21))
    print(("%s"):format(b.mass), tostring(print):match("^function: #%d+$") ~= nil)
  )") == "method body:position() -> x, y, z\nmethod body:alive() -> boolean\nmethod world:time() -> number\n"
         "function feder.deg(degrees) -> radians\nfunction feder.sphere\nmethod body:mass() -> number\ttrue\n");
}

TEST_CASE("a refused option leaves the world as it was", "[lua][options]") {
  CHECK(output_of(R"(
    world:body{ shape = feder.sphere(1), position = {0, 5, 0} }
    world:step(3)
    local before, bytes = world:hash(), world:report().bodies
    local ok = pcall(function() world:body{ shape = feder.sphere(1), tags = {"a"}, density = -1 } end)
    local ok2 = pcall(function() world:find("x"):position() end)
    local b = world:bodies()[1]
    local ok3 = pcall(b.set_position, b, 0/0, 0, 0)
    local ok4 = pcall(b.apply_impulse, b, 1, 2)
    print(ok, ok2, ok3, ok4, world:hash() == before, world:report().bodies == bytes)
  )") == "false\tfalse\tfalse\tfalse\ttrue\ttrue\n");
}

TEST_CASE("hot verbs take numbers or a table, and check both", "[lua][options]") {
  CHECK(output_of(R"(
    local b = world:body{ shape = feder.sphere(1) }
    print(b:set_velocity(1, 2, 3):velocity())
    print(b:set_velocity{3, 2, 1}:velocity())
    print(b:set_position(1, 0, 0) == b)
  )") == "1.0\t2.0\t3.0\n3.0\t2.0\t1.0\ntrue\n");
  const std::string make = "local b = world:body{ shape = feder.sphere(1) } ";
  CHECK(error_of(make + "b:set_velocity(1, 0/0, 0)") ==
        "test.lua:1: body:set_velocity.y: expected a finite number, got nan");
  CHECK(error_of(make + "b:set_velocity(1, 2)") ==
        "test.lua:1: body:set_velocity.z: expected a finite number, got nil");
  CHECK(error_of(make + "b:set_velocity({1, 2})") ==
        "test.lua:1: body:set_velocity: expected {x, y, z}, got a table of 2 values");
  CHECK(error_of(make + "b:set_velocity('1', '2', '3')") ==
        "test.lua:1: body:set_velocity.x: expected a finite number, got '1'");
  CHECK(error_of(make + "b.set_velocity({}, 1, 2, 3)") ==
        "test.lua:1: body:set_velocity: expected a body before the ':', got a table");
  CHECK(error_of(make + "b:move_to(0, 0, 0)") ==
        "test.lua:1: body:move_to: expected a kinematic body, got a dynamic one");
  CHECK(error_of(make + "b.foo = 1") == "test.lua:1: a body keeps no fields of a script; use a table keyed by it");
  CHECK(error_of(make + "b:positon()") == "test.lua:1: a body has no method 'positon'; did you mean 'position'?");
}

TEST_CASE("rotations in every form", "[lua][options]") {
  CHECK(output_of(R"(
    local function show(r)
      local x, y, z, w = world:body{ shape = feder.sphere(1), rotation = r }:rotation()
      print(("%.4f %.4f %.4f %.4f"):format(x, y, z, w))
    end
    show{ 0, 0, 1, 0 }
    show{ axis = {0, 3, 0}, angle = feder.deg(90) }
    show{ euler = {feder.deg(90), 0, 0} }
    show{ euler = {feder.deg(90), feder.deg(90), 0}, order = "xyz" }
    show{ euler = {feder.deg(90), feder.deg(90), 0}, order = "yxz", fixed = true }
  )") == "0.0000 0.0000 1.0000 0.0000\n0.0000 0.7071 0.0000 0.7071\n0.7071 0.0000 0.0000 0.7071\n"
         "0.5000 0.5000 0.5000 0.5000\n0.5000 0.5000 0.5000 0.5000\n");
}

TEST_CASE("materials give defaults, and pairs are known by name", "[lua][options]") {
  const std::string made =
      "local w = feder.world{ materials = { ice = { friction = 0.1, restitution = 0.2, density = 917 }, rubber = { "
      "friction = 1 } },"
      " material_pairs = { { 'ice', 'rubber', friction = 0.3 } } } ";
  CHECK(output_of(made +
                  "local b = w:body{ shape = feder.box(1, 1, 1), material = 'ice' } print(('%.1f'):format(b:mass()))"
                  " b = w:body{ shape = feder.box(1, 1, 1), material = 'ice', density = 100 } "
                  "print(('%.1f'):format(b:mass()))") == "917.0\n100.0\n");
  CHECK_THAT(error_of(made + "w:body{ shape = feder.box(1,1,1), material = 'icee' }"),
             Catch::Contains("unknown material 'icee'; known: ice, rubber"));
  CHECK_THAT(
      error_of("feder.world{ materials = { ice = { fricton = 1 } } }"),
      Catch::Contains("test.lua:1: feder.world.materials.ice: unknown option 'fricton'; did you mean 'friction'?"));
  CHECK_THAT(error_of("feder.world{ material_pairs = { { 'ice', 'mud' } } }"),
             Catch::Contains("feder.world.material_pairs[1]: unknown material 'ice'"));
}
