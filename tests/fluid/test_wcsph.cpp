// What wcsph alone has: its integrators, the damper of sound.
#include <cmath>

#include "feder/force.h"
#include "fluid/still_water.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A lone particle on a spring of 1 rad/s, from rest at 1 m: where it is after one second.
double swung(const std::string& integrator, int steps) {
  WorldDesc desc = weightless(fluid_world(3));
  desc.dt = 1.0 / steps, desc.substeps = 1;
  World w(desc, fluid_catalog());
  FluidDesc d;
  d.solver = "wcsph", d.integrator = integrator, d.spacing = 2, d.compression = Real(0.5);  // sound is slow: one step
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(d);
  const Vec3 here[] = {vec3(1, 0, 0)};
  f.fill(id, here, Vec3::Zero());
  Params p;
  p.set("stiffness", static_cast<double>(f.particle_mass(id)));
  ForceEntry target;
  target.target = id;
  w.add_force("spring", p, target, "", 0);
  for (int k = 0; k < steps; ++k) w.step();
  CHECK(f.solver_substeps(id) == static_cast<std::uint64_t>(steps));
  return static_cast<double>(places(w, id)[0][0]);
}

}  // namespace

TEST_CASE("wcsph's leapfrog is of second order, its Euler of first", "[fluid][wcsph]") {
  const std::string integrator = GENERATE("leapfrog", "symplectic_euler");
  CAPTURE(integrator);
  const double coarse = swung(integrator, 8), middle = swung(integrator, 16), fine = swung(integrator, 32);
  CHECK(fine == Approx(std::cos(1.0)).epsilon(0.03));
  CHECK((coarse - middle) / (middle - fine) == Approx(integrator == "leapfrog" ? 4 : 2).epsilon(0.06));
}

TEST_CASE("wcsph holds still water with each integrator", "[fluid][wcsph][still]") {
  StillWater s;
  s.solver = "wcsph", s.integrator = GENERATE("leapfrog", "symplectic_euler"), s.seconds = 2.5 * kShare;
  CAPTURE(s.integrator);
  const StillWaterResult r = run_still_water(s);
  CHECK(r.burst < 0);
  CHECK(r.warned < 0);
}

TEST_CASE("a fluid knows no other integrator", "[fluid][wcsph]") {
  World w(fluid_world(2), fluid_catalog());
  FluidDesc d;
  d.integrator = "rk4";
  CHECK_THROWS_WITH(w.need<Fluid>().add_fluid(d), Catch::Contains("symplectic_euler"));
}
