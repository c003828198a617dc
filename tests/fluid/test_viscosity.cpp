// Fluids so viscous that an explicit step would burst (fluid/viscosity.cpp): any step will do, what is thicker flows
// less, bodies are part of the solve, and no momentum is lost.
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"

using namespace feder;

namespace {

WorldDesc one_step(int dimension, double dt) {
  WorldDesc d = fluid_world(dimension);
  d.dt = dt, d.substeps = 1;
  return d;
}

// Height of a column of 8 x 20 spacings of 5 mm after half a second on a floor, over that at the start.
double slumped(const std::string& solver, double viscosity, double dt, const char* kernel = "") {
  World w(one_step(2, dt), fluid_catalog());
  add_plane(w, vec3(0, 1, 0), 0);
  FluidDesc d;
  d.solver = solver, d.spacing = Real(0.005), d.viscosity = static_cast<Real>(viscosity), d.max_substeps = 1000;
  d.viscosity_kernel = kernel;
  const ObjectId id = add_water(w, d, vec3(Real(0.04), Real(0.1), 0));
  run(w, 0.5);
  Real top = 0;
  for (const Vec3& x : places(w, id)) top = std::max(top, x[1]);
  CHECK(w.is_finite());
  for (const Event& e : w.events().list()) CHECK(e.kind != EventKind::warning);
  return static_cast<double>(top) / 0.1;
}

}  // namespace

TEST_CASE("what is thicker flows less, in steps of any length", "[fluid][viscosity]") {
  if (!kFull || kAsserts) return;
  const std::string solver = any_fluid_solver();
  const double thin = slumped(solver, 1, 1.0 / 60), honey = slumped(solver, 30, 1.0 / 60),
               pitch = slumped(solver, 3000, 1.0 / 60), long_steps = slumped(solver, 30, 1.0 / 30);
  CAPTURE(solver, thin, honey, pitch, long_steps);
  CHECK(thin < 0.5);
  CHECK(honey > thin + 0.1);
  CHECK(pitch > honey + 0.05);
  // it sinks at rho g H / (4 mu) over the height at first (Trouton 1906: 3 mu along an axis, 4 mu in the plane); what
  // pbf moves by pressure it moves without viscosity, so it flows on in long steps
  CHECK(pitch > (solver == "pbf" ? 0.4 : 0.93));
  CHECK(long_steps == Approx(honey).margin(0.06));
}

TEST_CASE("viscosity by another kernel than that of the densities flows as fast", "[fluid][viscosity]") {
  if (!kFull || kAsserts) return;
  const double own = slumped("dfsph", 30, 1.0 / 60);
  for (const char* kernel : {"cubic", "viscosity"}) {
    CAPTURE(kernel);
    CHECK(slumped("dfsph", 30, 1.0 / 60, kernel) == Approx(own).margin(0.05));
  }
}

TEST_CASE("confinement keeps eddies turning, and momentum", "[fluid][vorticity]") {
  const std::string solver = any_fluid_solver();
  double energy[2];
  for (int k = 0; k < 2; ++k) {
    World w(weightless(fluid_world(2)), fluid_catalog());
    Fluid& f = w.need<Fluid>();
    FluidDesc d;
    d.solver = solver, d.spacing = Real(0.02), d.vorticity = Real(10 * k);
    const ObjectId id = f.add_fluid(d);
    f.fill(id, *make_sphere(Real(0.3))->section(), Pose{}, Vec3::Zero());
    std::vector<Vec3> v;
    for (const Vec3& x : places(w, id)) {  // an eddy off the middle
      const Vec3 from = x - vec3(Real(0.1), 0, 0);
      const Real speed = std::exp(-dot(from, from) / Real(0.01));
      v.push_back(10 * speed * cross(vec3(0, 0, 1), from));
    }
    f.set_velocities(id, v);
    const Momentum before = w.momentum();
    run(w, 0.3);
    const Momentum after = w.momentum();
    const double mass = static_cast<double>(f.particle_mass(id)) * static_cast<double>(f.particle_count(id));
    for (int n = 0; n < 2; ++n) CHECK(std::fabs(after.linear[n] - before.linear[n]) < 1e-5 * mass);
    energy[k] = w.energy().kinetic;
    CHECK(w.is_finite());
  }
  CAPTURE(solver, energy[0], energy[1]);
  if (kFull) CHECK(energy[1] > 1.2 * energy[0]);
}

TEST_CASE("honey keeps momentum, with a light body in it", "[fluid][viscosity]") {
  const std::string solver = any_fluid_solver();
  const double density = GENERATE(20.0, 2000.0);
  World w(weightless(one_step(3, 1.0 / 60)), fluid_catalog());
  FluidDesc d;
  d.solver = solver, d.spacing = Real(0.02), d.viscosity = 500;
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(d);
  f.fill(id, *make_sphere(Real(0.1)), Pose{}, vec3(1, 0, 0));
  BodyDesc b;
  b.shape = make_box(Real(0.1), Real(0.1), Real(0.1)), b.density = static_cast<Real>(density);
  b.position = vec3(Real(0.16), Real(0.03), 0), b.velocity = vec3(-1, 0, 0);
  const ObjectId body = w.need<Rigid>().add_body(b);
  const Momentum before = w.momentum();
  run(w, 0.4 * kShare);
  const Momentum after = w.momentum();
  double off = 0;
  const double scale =
      static_cast<double>(f.particle_mass(id)) * static_cast<double>(f.particle_count(id)) + density * 0.001;
  for (int k = 0; k < 3; ++k) off = std::max(off, std::fabs(after.linear[k] - before.linear[k]) / scale);
  CAPTURE(solver, density, off);
  CHECK(off < 1e-5);
  CHECK(w.is_finite());
  // what sticks together moves as one
  if (kFull) CHECK(length(w.need<Rigid>().velocity(body)) < 2);
}
