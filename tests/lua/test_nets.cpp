// Nets from scripts: kinds of springs, forces on some points, builders, advice.
#include "support/script.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("springs that only pull, and those that break, keep their options", "[lua][nets]") {
  CHECK(output_of(R"(
    local net = world:net{ points = {{0,9,0},{1,9,0},{2,9,0}}, springs = {{1,2},{2,3, tension_only = false, break_strain = 0.25}},
      tension_only = true }
    print(net:spring_limits(1))
    print(net:spring_limits(2))
    local k = net:add_spring(1, 3, { stiffness = 5, tension_only = true })
    print(k, net:spring_limits(k))
  )") == "inf\ttrue\t1\n0.25\tfalse\t1\n3\tinf\ttrue\t1\n");
  CHECK_THAT(error_of("world:net{ points = {{0,0,0},{1,0,0}}, springs = {{1,2, tension_only = 1}} }"),
             Catch::Contains("springs[1].tension_only: expected true or false, got 1"));
}

TEST_CASE("a force acts on the points it is given", "[lua][nets]") {
  const std::string net = "local net = world:net{ points = {{0,0,0},{1,0,0},{2,0,0}}, masses = 2, gravity_scale = 0 } ";
  const char* const show =
      "world:step(60) for i = 1, 3 do local x, y, z = net:velocity(i) print(('%.2f'):format(z)) end";
  CHECK(output_of(net + "world:force{ kind = 'gravity', acceleration = {0,0,3}, on = net, points = {3, 1, 3} } " +
                  show) == "3.00\n0.00\n3.00\n");
  CHECK(output_of(net + "world:force{ on = net, points = {2}, each = function() return 0, 0, 4 end } " + show) ==
        "0.00\n2.00\n0.00\n");
  CHECK_THAT(error_of(net + "world:force{ kind = 'drag', points = {1} }"),
             Catch::Contains("points: expected on = a net"));
  CHECK_THAT(error_of(net + "world:force{ kind = 'drag', on = net, points = {4} }"),
             Catch::Contains("points[1]: expected a whole number from 1 to 3, got 4"));
  CHECK_THAT(error_of(net + "world:force{ kind = 'drag', on = net, points = {} }"),
             Catch::Contains("at least one point"));
}

TEST_CASE("a ball of tetrahedra is round, filled and well shaped", "[lua][nets]") {
  lua::HostOptions options;
  options.library_roots = {std::string(FEDER_SOURCE_DIR) + "/scripts"};
  CHECK(output_of(R"(
    local build = require "feder.build"
    for n = 1, 4 do
      local points, springs, faces, cells, inside = build.ball{ radius = 2, position = {1, 2, 3}, layers = n }
      local skin = 10 * n * n + 2
      assert(#cells == 20 * n ^ 3 and #faces == 20 * n * n and #points - inside == skin, n)
      assert(#points - #springs + (#faces + 4 * #cells) / 2 - #cells == 1, "Euler's formula of a ball")
      local volume, least, most = 0, math.huge, 0
      for _, c in ipairs(cells) do
        local v = build.volume(points, c)
        volume, least, most = volume + v, math.min(least, v), math.max(most, v)
      end
      local sphere = 4 / 3 * math.pi * 8
      assert(least > 0.3 * volume / #cells and most < 2.5 * volume / #cells, ("cells %g to %g"):format(least, most))
      assert(volume > (n == 1 and 0.6 or 0.8) * sphere and volume < sphere, volume / sphere)
      local function length(i, j)
        local a, b = points[i], points[j]
        return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)
      end
      local short, long = math.huge, 0
      for _, s in ipairs(springs) do
        short, long = math.min(short, length(s[1], s[2])), math.max(long, length(s[1], s[2]))
      end
      assert(long < 2 * short, ("edges %g to %g"):format(short, long))
      for i = inside + 1, #points do
        local p = points[i]
        assert(math.abs(math.sqrt((p[1] - 1) ^ 2 + (p[2] - 2) ^ 2 + (p[3] - 3) ^ 2) - 2) < 1e-9)
      end
      -- faces look outwards
      for _, f in ipairs(faces) do
        assert(build.volume({ {1, 2, 3}, points[f[1]], points[f[2]], points[f[3]] }, {1, 2, 3, 4}) > 0)
      end
    end
    print("good")
  )",
                  options) == "good\n");
}

TEST_CASE("advice names the limit, and what would do", "[lua][nets]") {
  const std::string rope = R"(
    local points, springs = {}, {}
    for i = 1, 30 do points[i] = { i, 0, 0 }; if i > 1 then springs[i - 1] = { i - 1, i } end end
    world:net{ name = "rope", points = points, springs = springs, stiffness = 1e6, integrator = )";
  const char* const show = R"(}
    local row = feder.advise(world)[1]
    print(row.object:name(), row.verdict, row.method, row.integrator, row.substeps, row.limit, ("%.4f"):format(row.hw))
    print(row.text))";
  // 2 sqrt(k/m) = 2000/s with 4 substeps of 1/240 s
  const std::string stiff = output_of(rope + "'symplectic_euler'" + show);
  CHECK_THAT(stiff, Catch::Contains("rope\tunstable\tsymplectic_euler\tsymplectic_euler\t19\t2.0\t8.3333\n"));
  CHECK_THAT(stiff, Catch::Contains(
                        "net \"rope\" with symplectic_euler may blow up: h w up to 8.33, the limit is 2; 19 substeps"));
  const std::string never = output_of(rope + "'explicit_euler'" + show);
  CHECK_THAT(never, Catch::Contains("rope\tnever stable\texplicit_euler\tsymplectic_euler\t19\t0.0\t8.3333\n"));
  const std::string implicit = output_of(rope + "'implicit_euler'" + show);
  CHECK_THAT(implicit, Catch::Contains("rope\tstable\timplicit_euler\timplicit_euler\t4\tinf\t8.3333\n"));
  CHECK_THAT(implicit, Catch::Contains("no limit") && Catch::Contains("damped out"));
  CHECK(output_of("print(#feder.advise(world))") == "0\n");
  CHECK_THAT(error_of("feder.advise(3)"), Catch::Contains("feder.advise: expected a world, got 3"));
}
