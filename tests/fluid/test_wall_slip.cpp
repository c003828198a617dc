// Friction of viscous fluid at walls, and its absence.
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A block of fluid slides between two plates: speed along them after `seconds`, from 1 m/s.
double speed_after(const FluidDesc& d, double seconds, int dimension) {
  WorldDesc desc = fluid_world(dimension);
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  const Real height = Real(0.4);
  add_plane(w, vec3(0, 1, 0), 0), add_plane(w, vec3(0, -1, 0), -height);
  const ObjectId id = add_water(w, d, vec3(1, height, dimension == 3 ? height : Real(0)));
  const std::vector<Vec3> v(w.need<Fluid>().particle_count(id), vec3(1, 0, 0));
  w.need<Fluid>().set_velocities(id, v);
  const double mass = static_cast<double>(w.need<Fluid>().particle_mass(id)) * static_cast<double>(v.size());
  run(w, seconds);
  return w.momentum().linear[0] / mass;
}

}  // namespace

TEST_CASE("viscous fluid slides along walls with free slip, and sticks to them without", "[fluid][slip]") {
  FluidDesc d;
  d.spacing = Real(0.05), d.viscosity = 50, d.solver = any_fluid_solver();
  const int dimension = GENERATE(2, 3);
  CAPTURE(d.solver, dimension);
  if (!kLarge && dimension == 3) return;
  const double seconds = 0.5 * kShare;
  d.wall_slip = "free";
  CHECK(speed_after(d, seconds, dimension) == Approx(1).margin(1e-3));
  d.wall_slip = "none";
  const double stuck = speed_after(d, seconds, dimension);
  if (!kFull) return;
  // decay of the first mode of a channel, exp(-nu pi^2 t / H^2) 8 / pi^2; eight layers between the plates
  CHECK(stuck == Approx(8 / 9.87 * std::exp(-0.05 * 9.87 * 0.5 / 0.16)).margin(0.07));
  d.viscosity = 0;
  CHECK(speed_after(d, seconds, dimension) == Approx(1).margin(1e-3));
}

TEST_CASE("other words for the slip of walls are refused", "[fluid][slip]") {
  World w(fluid_world(), fluid_catalog());
  FluidDesc d;
  CHECK(d.wall_slip == "none");
  d.wall_slip = "partial";
  CHECK_THROWS_WITH(w.need<Fluid>().add_fluid(d), Catch::Contains("expected \"none\" or \"free\", got \"partial\""));
}
