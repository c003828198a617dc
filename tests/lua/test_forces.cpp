// Forces from scripts inside a step: formulas, functions asked at every stage, attraction between the points of a net.
#include <cmath>
#include <sstream>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

// A Duffing oscillator by rk4, its place after 5 s with h = 5/steps; `force` is its world:force table.
std::string duffing(const std::string& force, int steps) {
  return "local w = feder.world{ dt = 5/" + std::to_string(steps) +
         ", substeps = 1, gravity = {0,0,0} } "
         "local net = w:net{ points = {{1,0,0}}, integrator = 'rk4' } w:force{ on = net, " +
         force + " } w:step(" + std::to_string(steps) + ") print(('%.9g'):format((net:point(1)))) ";
}

double place(const std::string& force, int steps) {
  double x = 0;
  std::istringstream(output_of(duffing(force, steps))) >> x;
  return x;
}

}  // namespace

TEST_CASE("formulas and functions asked at every stage keep the order of the method", "[lua][forces]") {
  const std::string formula =
      GENERATE("each = '-x - b*x^3', params = { b = 2 }", "each = function(x) return -x - 2*x^3 end, stages = true");
  const std::string held = "each = function(x) return -x - 2*x^3 end";
  CAPTURE(formula);
  const double exact = place("each = { '-x - 2*x^3', '0', 0 }", 2000);
  const double coarse = std::fabs(place(formula, 20) - exact), fine = std::fabs(place(formula, 40) - exact);
  const double wrong = std::fabs(place(held, 40) - exact);
  CHECK(std::log2(coarse / fine) == Approx(4).margin(0.5));
  CHECK(wrong > 50 * fine);
  CHECK(std::fabs(place(formula, 200) - exact) < 1e-5);  // of float velocities
}

TEST_CASE("a held force is warned about with the order and the cure", "[lua][forces]") {
  const std::string out = output_of(
      "local w = feder.world{} local net = w:net{ name = 'mast', points = {{1,0,0}}, integrator = 'rk4' } "
      "w:on('warning', function(e) print(e.code, e.message) end) "
      "w:force{ name = 'pull', on = net, each = function(x) return -x end } w:step(3)");
  CHECK(out ==
        "frozen_force\tforce \"pull\" is asked once before each step and held through it: with it net \"mast\" moves "
        "with order 1, not 4 of rk4; give each as a formula in quotes, or stages = true\n");
}

TEST_CASE("the profile counts each call of a force, whatever it acts on", "[lua][forces]") {
  const std::string on = GENERATE("w:net{ points = {{0,0,0}, {1,0,0}} }",
                                  "w:cloth{ size = {1, 1}, resolution = {2, 2} }", "w:body{ shape = feder.sphere(1) }");
  CAPTURE(on);
  lua::Script script(lua::HostOptions{});
  script.load_string(
      "local feder = require 'feder' calls = 0 local w = feder.world{ gravity = {0,0,0} } "
      "w:force{ on = " +
          on + ", each = function() calls = calls + 1 return 0, 1, 0 end } w:step(3)",
      "test.lua");
  std::uint64_t calls = 0;
  for (const lua::HandlerProfile& p : script.handler_profile()) calls += p.calls;
  CHECK(calls >= 3);
  CHECK(std::to_string(calls) == script.run_string("return calls"));
}

TEST_CASE("formulas in world:force name what is wrong", "[lua][forces]") {
  const std::string net = "local net = world:net{ points = {{1,0,0}} } ";
  const auto error = [&](const char* force) { return error_of(net + "world:force{ on = net, " + force + " }"); };
  CHECK_THAT(error("each = '-q*x'"), Catch::Contains("world:force.each: x: column 2 of '-q*x': unknown name 'q'"));
  CHECK_THAT(error("each = {'0', 'sin(x'}"), Catch::Contains("each: y: column 6") && Catch::Contains("expected ')'"));
  CHECK_THAT(error("each = {}"), Catch::Contains("one to three formulas, got 0"));
  CHECK_THAT(error("each = {true}"), Catch::Contains("expected formulas in quotes, got true"));
  CHECK_THAT(error("each = 'k*x', params = { k = 'a' }"), Catch::Contains("params.k: expected a"));
  CHECK_THAT(error("each = 'x', params = { m = 1 }"), Catch::Contains("no variable or function, got 'm'"));
  CHECK_THAT(error("each = 'x', params = { y = 1 }"), Catch::Contains("no variable or function, got 'y'"));
  CHECK_THAT(error("each = 'x', stages = false"), Catch::Contains("every stage"));
}

TEST_CASE("a force asked at every stage may read the world and not edit it", "[lua][forces]") {
  const std::string start = "local net = world:net{ points = {{1,0,0}}, integrator = 'rk4', gravity_scale = 0 } ";
  CHECK(output_of(start +
                  "local calls, late = 0, 0 world:force{ on = net, stages = true, each = function(x,y,z,vx,vy,vz,m,t) "
                  "calls = calls + 1 if t > world:time() then late = late + 1 end return -net:mass(1) end } "
                  "world:step() print(calls, late)") == "16\t15\n");
  for (const std::string edit : {"net:set_point(1, 0, 0, 0)", "net:pin(1)", "world:body{ shape = feder.sphere(1) }",
                                 "net:destroy()", "world:step()", "world:set_gravity(0,0,0)"}) {
    const Ran ran = run(start + "world:force{ on = net, stages = true, each = function() " + edit +
                        " end } world:step() print(net:point(1))");
    CAPTURE(edit);
    CHECK(ran.error == "");
    REQUIRE(ran.errors.size() == 1);
    CHECK_THAT(ran.errors[0].message, Catch::Contains("read-only"));
    CHECK(ran.output == "1.0\t0.0\t0.0\n");
  }
}

TEST_CASE("after an error the force is nothing for the rest of the step and asked again in the next", "[lua][forces]") {
  const Ran ran =
      run("local w = feder.world{ gravity = {0,0,0}, dt = 1, substeps = 1 } "
          "local net = w:net{ points = {{0,0,0}}, integrator = 'symplectic_euler' } local calls = 0 "
          "w:force{ on = net, stages = true, each = function() calls = calls + 1 if calls == 1 then error('no') end "
          "return 3 end } "
          "w:step() print(calls, (net:velocity(1))) w:step() print(calls > 1, (net:velocity(1)))");
  CHECK(ran.error == "");
  CHECK(ran.output == "1\t0.0\ntrue\t3.0\n");
  REQUIRE(ran.errors.size() == 1);
  CHECK_THAT(ran.errors[0].message, Catch::Contains("no"));
}

TEST_CASE("the points of a net attract each other", "[lua][forces]") {
  CHECK(output_of("local w = feder.world{ gravity = {0,0,0}, dt = 1e-3, substeps = 1 } "
                  "local net = w:net{ points = {{0,0,0},{2,0,0}}, masses = {1, 3} } "
                  "w:force{ kind = 'attractor', between = net, strength = 4, power = -2 } w:step() "
                  "print(('%.4f %.4f'):format((net:velocity(1)), (net:velocity(2))))") == "0.0030 -0.0010\n");
  CHECK_THAT(error_of("local net = world:net{ points = {{0,0,0}} } "
                      "world:force{ kind = 'attractor', between = net, on = net }"),
             Catch::Contains("between: expected neither on nor position"));
  CHECK_THAT(error_of("local b = world:body{ shape = feder.sphere(1) } world:force{ kind = 'attractor', between = b }"),
             Catch::Contains("between: expected a net"));
}

TEST_CASE("springs with a power from scripts", "[lua][forces]") {
  CHECK(output_of("local net = world:net{ points = {{0,0,0},{1,0,0}}, springs = {{1,2, power = 3, stiffness = 5}} } "
                  "print(net:spring_limits(1))") == "inf\tfalse\t3\n");
  CHECK_THAT(error_of("world:net{ points = {{0,0,0},{1,0,0}}, springs = {{1,2, power = 1.5}} }"),
             Catch::Contains("springs[1].power: expected a whole number from 1 to 9"));
}
