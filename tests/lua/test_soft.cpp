// Soft bodies in scripts: what they are made of, what they are held to, and what is said when they cannot be.
#include "support/script.h"

using namespace feder::test;

TEST_CASE("a soft body answers what it is", "[lua][soft]") {
  CHECK(output_of(R"(
    local jelly = world:soft{ name = "jelly", shape = feder.box(0.2, 0.2, 0.4), resolution = 4, position = {0, 3, 0} }
    print(jelly:kind(), jelly:name(), jelly:count())
    print(jelly:tetrahedron(1))
    print(string.format("%.4f %.4f %.1f", jelly:volume(), jelly:rest_volume(), jelly:mass()), jelly:inverted())
    local b = jelly:points()
    local x, y, z = jelly:point(1)
    print(#b, b[1] == x, b[2] == y, b[3] == z, jelly:awake())
    world:step(5)
    print(jelly:strain() < 1e-4, jelly:strain(7) <= jelly:strain(), select(2, jelly:velocity(1)) < 0)
    jelly:destroy()
    print(jelly:alive())
  )") == "soft\tjelly\t45\t80\n1\t2\t4\t10\n0.0160 0.0160 "
         "16.0\t0\n135\ttrue\ttrue\ttrue\ttrue\ntrue\ttrue\ttrue\nfalse\n");
}

TEST_CASE("a soft body says which of its tetrahedra is at a place, and where in it", "[lua][soft]") {
  CHECK(output_of(R"(
    local jelly = world:soft{ shape = feder.box(0.2, 0.2, 0.4), resolution = 4, position = {0, 3, 0},
      rotation = { axis = {0, 1, 0}, angle = 0.5 } }
    local k, a, b, c, d = jelly:tetrahedron_at(0.03, 3.02, 0.01)
    local x, y, z = 0, 0, 0
    for n, w in ipairs{a, b, c, d} do
      local i = select(n, jelly:tetrahedron(k))
      local px, py, pz = jelly:point(i)
      x, y, z = x + w * px, y + w * py, z + w * pz
    end
    print(string.format("%.4f %.4f %.4f %.4f", x, y, z, a + b + c + d), math.min(a, b, c, d) >= 0)
    print(jelly:tetrahedron_at(0.3, 3, 0), jelly:tetrahedron_at({0, 4, 0}))
  )") == "0.0300 3.0200 0.0100 1.0000\ttrue\nnil\tnil\n");
}

TEST_CASE("what finds contacts of a soft body with itself is named", "[lua][soft]") {
  CHECK(output_of(R"(
    for _, self in ipairs(feder.choices("soft.self")) do
      local jelly = world:soft{ shape = feder.box(0.2, 0.2, 0.2), resolution = 2, position = {0, 3, 0}, self = self }
      world:step(3)
      print(self, jelly:strain() < 1e-5)
      jelly:destroy()
    end
    print(pcall(function() world:soft{ shape = feder.box(1, 1, 1), self = "sphere_tre" } end))
  )") == "swept_boxes\ttrue\nhash\ttrue\nsphere_tree\ttrue\ncullide\ttrue\n"
         "false\ttest.lua:8: world:soft: unknown search of self-contact 'sphere_tre'; known: swept_boxes, hash, "
         "sphere_tree, cullide\n");
}

TEST_CASE("a soft body breaks in parts, and an event says where", "[lua][soft]") {
  CHECK(output_of(R"(
    world:set_gravity(0, 0, 0)
    local bar = world:soft{ name = "bar", shape = feder.box(1, 0.25, 0.25), resolution = 4, damping = 0.02,
      fracture_stress = 5e3 }
    local points = bar:count()
    for i = 1, points do bar:set_velocity(i, 6 * bar:rest_point(i), 0, 0) end
    local seen
    world:on("fracture", function(e) seen = seen or e:copy() end)
    world:step(30)
    print(bar:parts() >= 2, bar:count() > points, bar:part(1) == 1, bar:tension(1) < 5e3)
    print(seen.kind, seen.object == bar, seen.index <= points, seen.part >= 1, seen.force > 0)
  )") == "true\ttrue\ttrue\ttrue\nfracture\ttrue\ttrue\ttrue\ttrue\n");
}

TEST_CASE("a soft body that flows keeps a new shape, and says what plastic is made of", "[lua][soft]") {
  CHECK(output_of(R"(
    world:set_gravity(0, 0, 0)
    local clay = world:soft{ shape = feder.box(0.2, 0.2, 0.2), resolution = 2, plastic = { yield = 0.02, flow = 50 } }
    for i = 1, clay:count() do
      local x, y, z = clay:rest_point(i)
      clay:pin(i)
      clay:set_point(i, 1.21 * x, y / 1.1, z / 1.1)
    end
    world:step(60)
    for i = 1, clay:count() do clay:unpin(i) end
    world:step(120)
    local long = 0
    for i = 1, clay:count() do long = math.max(long, 2 * clay:point(i)) end
    print(math.abs(long / 0.2 - 1.21 / math.exp(0.02)) < 0.005)
    for _, plastic in ipairs{ { yield = 0.1 }, { yield = -1, flow = 1 }, 3 } do
      print(pcall(function() world:soft{ shape = feder.box(1, 1, 1), plastic = plastic } end))
    end
    print(pcall(function() world:soft{ shape = feder.box(1, 1, 1), fracture_stress = 0 } end))
  )") == "true\nfalse\ttest.lua:16: world:soft.plastic: expected { yield =, flow = }, got no flow\n"
         "false\ttest.lua:16: world:soft.plastic.yield: expected a number of at least 0, got -1\n"
         "false\ttest.lua:16: world:soft.plastic: expected { yield =, flow = }, got 3\n"
         "false\ttest.lua:18: world:soft.fracture_stress: expected a number above 0, got 0\n");
}

TEST_CASE("a rope, a cloth, a net and a body hang from a soft body", "[lua][soft]") {
  CHECK(output_of(R"(
    local jelly = world:soft{ shape = feder.box(0.2, 0.2, 0.2), resolution = 2, position = {0, 3, 0}, young = 1e5 }
    local function nearest(x, y, z)
      local best, least = nil, 1e9
      for i = 1, jelly:count() do
        local a, b, c = jelly:rest_point(i)
        local d = (a - x)^2 + (b - y)^2 + (c - z)^2
        if d < least then best, least = i, d end
      end
      return best
    end
    for _, x in ipairs{-0.1, 0, 0.1} do for _, z in ipairs{-0.1, 0, 0.1} do jelly:pin(nearest(x, 0.1, z)) end end
    local middle = nearest(0, 0, 0)   -- within
    local rope = world:rope{ from = {0, 3, 0}, to = {0, 2.5, 0}, segments = 5, mask = 0 }
    rope:attach(1, jelly, middle)
    local crate = world:body{ shape = feder.box(0.1, 0.1, 0.1), mass = 0.2, position = {0.1, 2.85, 0.1} }
    jelly:attach(nearest(0.1, -0.1, 0.1), crate, 0, 0.05, 0)
    local sheet = world:cloth{ size = {0.1, 0.1}, resolution = {3, 3}, position = {-0.1, 2.9, -0.1}, mask = 0 }
    sheet:attach(5, jelly, nearest(-0.1, -0.1, -0.1))
    local net = world:net{ points = {{-0.1, 2.9, 0.1}, {-0.1, 2.7, 0.1}}, masses = 0.05, springs = {{1, 2}}, radius = 0.01, mask = 0 }
    net:attach(1, jelly, nearest(-0.1, -0.1, 0.1))
    world:on("warning", function(e) print(e.code, e.message) end)
    world:step(90)
    local function apart(a, i, b, j)
      local x, y, z = a:point(i)
      local u, v, w = b:point(j)
      return math.sqrt((x - u)^2 + (y - v)^2 + (z - w)^2)
    end
    print(apart(rope, 1, jelly, middle) < 0.005, apart(sheet, 5, jelly, nearest(-0.1, -0.1, -0.1)) < 0.01,
          apart(net, 1, jelly, nearest(-0.1, -0.1, 0.1)) < 0.01, select(2, crate:position()) > 2.7)
  )") == "true\ttrue\ttrue\ttrue\n");
}

TEST_CASE("every solver of soft bodies and every law of elasticity is there for scripts", "[lua][soft]") {
  CHECK(output_of(R"(
    for _, solver in ipairs(feder.choices("soft.solver")) do
      for _, law in ipairs(feder.choices("soft.elasticity")) do
        local ok = pcall(function()
          local jelly = world:soft{ shape = feder.box(0.2, 0.2, 0.2), resolution = 2, position = {0, 3, 0}, solver = solver,
            elasticity = law }
          world:step(3)
          assert(jelly:strain() < 1e-5)
          jelly:destroy()
        end)
        if ok then print(solver, law) end
      end
    end
  )") == "xpbd\tneo_hookean\nvbd\tneo_hookean\nvbd\tstvk\nimplicit\tneo_hookean\nimplicit\tcorotated\n"
         "implicit\tstvk\nmass_spring\tneo_hookean\n");
}

TEST_CASE("soft bodies that cannot be are errors with what was expected", "[lua][soft]") {
  const auto error = [](const std::string& options) { return error_of("world:soft{ " + options + " }"); };
  CHECK_THAT(error(""), Catch::Contains("shape: expected a shape, or points and tetrahedra, got nil"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), points = {{0, 0, 0}}"), Catch::Contains("fills a shape"));
  CHECK_THAT(error("points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, tetrahedra = {{1, 2, 3, 5}}"),
             Catch::Contains("tetrahedra[1]") && Catch::Contains("4"));
  CHECK_THAT(error("points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, tetrahedra = {{1, 2, 3, 4}}"),
             Catch::Contains("tetrahedra[1]: expected four corners with a volume between them"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), poisson = 0.5"), Catch::Contains("poisson: expected"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), young = 0"), Catch::Contains("young: expected"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), solver = 'xpdb'"), Catch::Contains("xpbd"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), elasticity = 'stvk'"),
             Catch::Contains("elasticity: expected what xpbd has (neo_hookean), got stvk") &&
                 Catch::Contains("vbd, implicit"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), elasticity = 'corotatd'"), Catch::Contains("corotated"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), solver = 'implicit', solver_options = { iteration = 5 }"),
             Catch::Contains("iterations"));
  CHECK_THAT(error("shape = feder.plane()"), Catch::Contains("expected a solid"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), resolution = 1000"), Catch::Contains("at most 1e7 cells"));
  CHECK_THAT(error("shape = feder.box(1, 1, 1), yuong = 5"), Catch::Contains("young"));
}
