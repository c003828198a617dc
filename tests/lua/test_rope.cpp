// Ropes in scripts: what they are made of, what they hang from, and what is said when nothing holds them.
#include "support/script.h"

using namespace feder::test;

TEST_CASE("a rope hangs from a cloth and carries a body, whichever side attached", "[lua][rope]") {
  CHECK(output_of(R"(
    local sheet = world:cloth{ size = {0.2, 0.2}, resolution = {3, 3}, position = {0, 2, 0}, pins = { 1, 2, 3, 4, 6, 7, 8, 9 } }
    local rope = world:rope{ from = {0, 2, 0}, to = {0, 1, 0}, segments = 10, radius = 0.01 }
    local crate = world:body{ shape = feder.box(0.1, 0.1, 0.1), mass = 1, position = {0, 0.95, 0} }
    assert(sheet:attach(5, rope, 1) == sheet and rope:attach(11, crate) == rope)
    print(rope:kind(), rope:count())
    world:step(120)
    local _, top = rope:point(1)
    local _, low = crate:position()
    print(math.abs(top - select(2, sheet:point(5))) < 0.002, low > 0.9, rope:strain(1) < 0.05)
    rope:detach(11)
    world:step(60)
    print(select(2, crate:position()) < -1)
  )") == "rope\t11\t10\ntrue\ttrue\ttrue\ntrue\n");
}

TEST_CASE("an attachment over a gap, or to what nothing can be held to, says so", "[lua][rope]") {
  const auto told = [](const std::string& lines) {
    return output_of(
        "world:on('warning', function(e) print(e.code, e.message) end) "
        "local rope = world:rope{ name = 'line', from = {0, 2, 0}, to = {1, 2, 0}, segments = 10, radius = 0.01 } " +
        lines + " world:step(3)");
  };
  const std::string net =
      "local net = world:net{ name = 'net', points = {{1, 2, 0}, {2, 2, 0}}, masses = {0.05, 0.05}, "
      "springs = {{1, 2, stiffness = 100}}";
  CHECK_THAT(told(net + " } rope:attach(11, net, 1)"), Catch::StartsWith("attachment_lost\t") &&
                                                           Catch::Contains("net \"net\"") &&
                                                           Catch::Contains("radius above 0"));
  CHECK(told(net + ", radius = 0.01 } rope:attach(11, net, 1)") == "");
  CHECK_THAT(
      told("local other = world:rope{ name = 'other', from = {0, 3, 0}, to = {1, 3, 0}, segments = 10, "
           "radius = 0.01 } rope:attach(1, other, 1)"),
      Catch::StartsWith("attachment_gap\t") && Catch::Contains("rope \"other\"") && Catch::Contains("mean edges"));
}
