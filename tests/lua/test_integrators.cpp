// Integrators and their options from a script: by name, with errors that help, and honest about missed tolerances.
#include "integrate/integrator.h"
#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

const char* const kNet =
    "local net = world:net{ name = 'net', points = {{0,0,0},{1,0,0},{2,0,0}}, springs = {{1,2},{2,3}}, pins = {1}, ";

}  // namespace

TEST_CASE("every integrator runs a net from a script, and a restored run is the same", "[lua][integrate]") {
  const int row = GENERATE(range(0, static_cast<int>(integrators().size())));
  const std::string name = integrators()[static_cast<std::size_t>(row)].name;
  CAPTURE(name);
  CHECK(output_of(std::string(kNet) + "integrator = '" + name + R"(' }
    world:step(10)
    local s = world:snapshot()
    local function go() world:step(15); return world:hash() end
    local first = go()
    world:restore(s)
    print(go() == first, world:is_finite())
  )") == "true\ttrue\n");
}

TEST_CASE("options of integrators", "[lua][integrate]") {
  CHECK(output_of(std::string(kNet) +
                  "integrator = 'rk45', integrator_options = { tolerance = 1e-3 } } world:step(5)") == "");
  CHECK_THAT(error_of(std::string(kNet) + "integrator = 'rk45', integrator_options = { tolerence = 1e-3 } }"),
             Catch::Contains("rk45: unknown option 'tolerence'; did you mean 'tolerance'?"));
  CHECK_THAT(error_of(std::string(kNet) + "integrator = 'rk45', integrator_options = { colour = 1 } }"),
             Catch::Contains("rk45: unknown option 'colour'; known: absolute, adaptive, max_steps, tolerance"));
  CHECK_THAT(error_of(std::string(kNet) + "integrator = 'tr_bdf2', integrator_options = { solver = 'magic' } }"),
             Catch::Contains("solver: expected one of auto, direct, cg, got 'magic'"));
  CHECK_THAT(error_of(std::string(kNet) + "integrator = 'rk45', integrator_options = { tolerance = 2 } }"),
             Catch::Contains("tolerance: expected a number from"));
  CHECK_THAT(error_of(std::string(kNet) + "integrator = 'rk5' }"),
             Catch::Contains("unknown integrator 'rk5'; known: "));
}

TEST_CASE("a missed tolerance reaches the script as a warning", "[lua][integrate]") {
  CHECK(output_of(R"(
    local points, springs = {}, {}
    for i = 1, 30 do points[i] = { i * 0.1, 0, 0 }; if i > 1 then springs[i - 1] = { i - 1, i } end end
    world:net{ name = "rope", points = points, springs = springs, pins = { 1 }, stiffness = 1e6, integrator = "tr_bdf2",
      integrator_options = { solver = "cg", cg_iterations = 1, iterations = 2 } }
    world:on("warning", function(e) print(e.code or e.warning) end)
    world:step(3)
  )")
            .find("unconverged") != std::string::npos);
}
