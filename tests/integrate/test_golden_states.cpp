// x'' = -x from (1, 0), 100 steps of 0.1: the states that tell one method from its relatives (recurrences with
// 40 digits). Methods without a row here are checked by the contract alone.
#include <cstring>

#include "feder/memory.h"
#include "integrate/integrator.h"
#include "spring_field.h"
#include "support/catch.h"

using namespace feder;
using namespace feder::test;

namespace {

struct Golden {
  const char* name;
  double x, v;
};
constexpr Golden kGolden[] = {
    {"explicit_euler", -1.40884698291602, 0.848506928757779},
    {"symplectic_euler", -0.809384821133212, 0.548202119543514},
    {"midpoint", -0.830954421124927, 0.558585576515391},
    {"heun", -0.830954421124927, 0.558585576515391},
    {"rk2", -0.830954421124927, 0.558585576515391},
    {"rk4", -0.839075464413065, 0.544013766248773},
    {"velocity_verlet", -0.836794927110388, 0.546831614244655},
    {"leapfrog", -0.836794927110388, 0.548202119543514},
    {"implicit_euler", -0.520866526040103, 0.313702525300696},
    {"implicit_midpoint", -0.843569150875790, 0.537020565426222},
    {"bdf2", -0.847908113900278, 0.511506194132453},
    {"tr_bdf2", -0.841232004979200, 0.540606371998215},
    {"yoshida4", -0.839107570497260, 0.543967602785317},
    {"exponential", -0.839071529076452, 0.544021110889370},  // exact
};

}  // namespace

TEST_CASE("integrators reach their golden states", "[integrate]") {
  int found = 0;
  for (const Variant<Integrator>& method : integrators())
    for (const Golden& g : kGolden) {
      if (std::strcmp(method.name, g.name) != 0) continue;
      CAPTURE(method.name);
      Arena arena("test");
      const auto m = method.make(arena, Params());
      SpringField f = oscillator(1);
      State s{{Vec3(1, 0, 0)}, {Vec3(0, 0, 0)}};
      run(*m, f, s, 10, 100);
      const double margin = sizeof(Real) == 4 ? 2e-5 : 1e-12;
      CHECK(static_cast<double>(s.x[0][0]) == Approx(g.x).margin(margin));
      CHECK(static_cast<double>(s.v[0][0]) == Approx(g.v).margin(margin));
      ++found;
    }
  CHECK(found > 0);
}
