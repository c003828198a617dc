// A fluid between its particles: Fluid::sample against fields that are known, flux against rho v A, clumping.
#include <algorithm>
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

WorldDesc weightless(int dimension) {
  WorldDesc d = fluid_world(dimension);
  d.gravity = Vec3::Zero();
  return d;
}

// Row a, column b: d v_a / d x_b.
Vec3 linear_velocity(const Vec3& x, int dimension) {
  Vec3 v = vec3(1 + 2 * x[1], 3 * x[0] - x[1], 0);
  if (dimension == 3) v[2] = Real(0.5) * x[0] + 4 * x[2];
  return v;
}

void set_linear(World& w, ObjectId id) {
  std::vector<Vec3> v;
  for (const Vec3& x : places(w, id)) v.push_back(linear_velocity(x, w.desc().dimension));
  w.need<Fluid>().set_velocities(id, v);
}

FluidSample at(World& w, ObjectId id, const Vec3& x) { return w.query<Fluid>()->sample(id, x); }

}  // namespace

TEST_CASE("a sample is exact for linear fields, also at surfaces, and zero away from the fluid", "[fluid][sample]") {
  const int dimension = GENERATE(2, 3);
  FluidDesc d;
  d.spacing = Real(0.1), d.kernel = GENERATE("cubic", "wendland", "poly6_spiky");
  CAPTURE(dimension, d.kernel);
  World w(weightless(dimension), fluid_catalog());
  const Vec3 size = vec3(1, 1, dimension == 3 ? 1 : 0), middle = size / 2;
  const ObjectId id = add_water(w, d, size);
  set_linear(w, id);
  for (const Real x : {Real(0.02), Real(0.5), Real(0.53), Real(0.99)}) {
    CAPTURE(x);
    const Vec3 point = vec3(x, Real(0.47), middle[2]), v = linear_velocity(point, dimension);
    const FluidSample s = at(w, id, point);
    const bool inside = x > Real(0.3) && x < Real(0.7);
    // Shepard's mean lies off at the surface, its gradient does not
    CHECK(length(Vec3(s.velocity - v)) < (inside ? Real(0.03) : Real(0.3)));
    const Vec3 along_x = s.velocity_gradient.col(0), along_y = s.velocity_gradient.col(1);
    CHECK(length(Vec3(along_x - vec3(0, 3, dimension == 3 ? Real(0.5) : Real(0)))) < Real(0.02));
    CHECK(length(Vec3(along_y - vec3(2, -1, 0))) < Real(0.02));
    CHECK(s.velocity_gradient(2, 2) == Approx(dimension == 3 ? 4 : 0).margin(0.02));
    if (inside) CHECK(s.density == Approx(1000).epsilon(0.04));
    // the gradient of the density is that of its own values
    const Real e = Real(2e-3);
    const Real up = at(w, id, point + vec3(e, 0, 0)).density, down = at(w, id, point - vec3(e, 0, 0)).density;
    CHECK(s.density_gradient[0] == Approx((up - down) / (2 * e)).margin(200));
  }
  for (const Vec3& far : {vec3(3, 0, 0), vec3(Real(0.5), Real(-0.5), 0), vec3(-1, -1, 0)}) {
    const FluidSample s = at(w, id, far);
    CHECK(s.density == 0);
    CHECK(s.pressure == 0);
    CHECK(s.velocity.isZero(0));
    CHECK(s.density_gradient.isZero(0));
    CHECK(s.velocity_gradient.isZero(0));
  }
  CHECK_THROWS_AS(at(w, id, vec3(NAN, 0, 0)), SceneError);
}

TEST_CASE("walls do not lower the density of a sample, and air beside them has none", "[fluid][sample]") {
  const int dimension = GENERATE(2, 3);
  CAPTURE(dimension);
  World w(weightless(dimension), fluid_catalog());
  const bool deep = dimension == 3;
  add_tank(w, vec3(1, 1, deep ? Real(1) : Real(0)));
  FluidDesc d;
  d.spacing = Real(0.1);
  const ObjectId id = add_water(w, d, vec3(1, Real(0.5), deep ? Real(1) : Real(0)));
  const Real z = deep ? Real(0.5) : Real(0);
  for (const Real y : {Real(0.001), Real(0.02), Real(0.05), Real(0.1), Real(0.16), Real(0.25)}) {
    CAPTURE(y);
    CHECK(at(w, id, vec3(Real(0.5), y, z)).density == Approx(1000).epsilon(0.05));  // above the floor
    CHECK(at(w, id, vec3(y, y, z)).density == Approx(1000).epsilon(0.1));           // in the corner
  }
  CHECK(at(w, id, vec3(Real(0.01), Real(0.9), z)).density == 0);
  CHECK(at(w, id, vec3(Real(0.5), Real(-0.9), z)).density == 0);
  // no jump on the way out of the fluid along the wall
  Real before = at(w, id, vec3(Real(0.01), Real(0.3), z)).density;
  for (int k = 1; k <= 100; ++k) {
    const Real now = at(w, id, vec3(Real(0.01), Real(0.3) + Real(0.006) * static_cast<Real>(k), z)).density;
    CHECK(std::abs(now - before) < 100);
    before = now;
  }
  CHECK(before == 0);
}

TEST_CASE("a lone particle and particles in one place have finite samples", "[fluid][sample]") {
  World w(weightless(3), fluid_catalog());
  FluidDesc d;
  const ObjectId id = w.need<Fluid>().add_fluid(d);
  const Vec3 points[] = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 0, 0), vec3(1, 0, 0)};
  w.need<Fluid>().fill(id, points, vec3(2, 0, 0));
  for (const Vec3& x : places(w, id)) {
    const FluidSample s = at(w, id, x);
    CHECK(s.density > 0);
    CHECK(s.velocity[0] == Approx(2));
    CHECK(is_finite(s.pressure));
    CHECK(s.velocity_gradient.isZero(Real(1e-3)));
    CHECK((is_finite(s.density_gradient) && is_finite(s.pressure_gradient)));
  }
}

TEST_CASE("in still water the gradient of the pressure is the weight", "[fluid][sample]") {
  World w(fluid_world(2), fluid_catalog());
  add_tank(w, vec3(1, 1, 0));
  FluidDesc d;
  d.spacing = Real(0.05), d.solver = any_fluid_solver();
  CAPTURE(d.solver);
  const ObjectId id = add_water(w, d, vec3(1, 1, 0));
  run(w, 2 * kShare);
  if (!kFull) return;
  // over the middle of the tank and a second
  double along = 0, pressure = 0;
  int n = 0;
  for (int k = 0; k < 60; k += 6) {
    run(w, 0.1);
    for (Real x = Real(0.3); x < Real(0.71); x += Real(0.05), ++n) {
      const FluidSample s = at(w, id, vec3(x, Real(0.5), 0));
      along += static_cast<double>(s.pressure_gradient[1]), pressure += static_cast<double>(s.pressure);
      CHECK(static_cast<double>(s.pressure) == w.query<Fluid>()->pressure_at(id, vec3(x, Real(0.5), 0)));
    }
  }
  CHECK(along / n == Approx(-9810).epsilon(0.15));
  CHECK(pressure / n == Approx(4905).epsilon(0.1));
}

TEST_CASE("the flux of a block that moves is density times speed times section", "[fluid][sample]") {
  const int dimension = GENERATE(2, 3);
  CAPTURE(dimension);
  World w(weightless(dimension), fluid_catalog());
  FluidDesc d;
  d.spacing = Real(0.05), d.density = 800;
  const bool deep = dimension == 3;
  const ObjectId id = add_water(w, d, vec3(2, Real(0.4), deep ? Real(0.5) : Real(0)));
  const std::vector<Vec3> v(w.need<Fluid>().particle_count(id), vec3(3, Real(-0.5), 0));
  w.need<Fluid>().set_velocities(id, v);
  // a gate across the whole block, and one inside it that lies across the lattice
  const double wide = 800 * 3 * 0.4 * (deep ? 0.5 : 1);
  FluidFlux f = w.need<Fluid>().flux(id, vec3(Real(0.9), -1, -1), vec3(Real(1.03), 1, 1));
  CHECK(f.rate[0] == Approx(wide).epsilon(0.01));
  f = w.need<Fluid>().flux(id, vec3(Real(0.53), Real(0.11), Real(0.12)), vec3(Real(0.61), Real(0.22), Real(0.33)));
  const double depth = deep ? 0.21 : 1;
  CHECK(f.mass == Approx(800 * 0.08 * 0.11 * depth).epsilon(0.03));
  CHECK(f.rate[0] == Approx(800 * 3 * 0.11 * depth).epsilon(0.03));
  CHECK(f.rate[1] == Approx(-800 * 0.5 * 0.08 * depth).epsilon(0.03));
  CHECK(f.rate[2] == 0);
  CHECK(f.momentum[0] / f.mass == Approx(3));
  f = w.need<Fluid>().flux(id, vec3(5, 5, 5), vec3(6, 6, 6));
  CHECK((f.mass == 0 && f.rate[0] == 0));
  CHECK_THROWS_AS(w.need<Fluid>().flux(id, vec3(1, 0, 0), vec3(0, 1, 1)), SceneError);
}

TEST_CASE("over time the flux is the mass that has crossed, on average over the sections of the box",
          "[fluid][sample]") {
  World w(fluid_world(2), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  add_plane(w, vec3(0, 1, 0), 0);
  FluidDesc d;
  d.spacing = Real(0.05), d.solver = any_fluid_solver();
  CAPTURE(d.solver);
  const ObjectId id = add_water(w, d, vec3(1, 1, 0));
  const double mass = static_cast<double>(f.particle_mass(id));
  const auto beyond = [&] {
    double sum = 0;
    for (const Vec3& x : places(w, id)) sum += mass * std::clamp((static_cast<double>(x[0]) - 1.2) / 0.4, 0.0, 1.0);
    return sum;
  };
  double crossed = 0;
  run(w, 0.1);
  const double before = beyond();
  for (int k = 0; k < 60; ++k) {
    w.step();
    crossed += f.flux(id, vec3(Real(1.2), -1, 0), vec3(Real(1.6), 2, 0)).rate[0] * w.desc().dt;
  }
  CHECK(beyond() - before > 200);  // of 1000 kg
  CHECK(crossed == Approx(beyond() - before).epsilon(0.03));
}

TEST_CASE("clumping counts pairs closer than half a spacing", "[fluid][sample]") {
  World w(weightless(3), fluid_catalog());
  FluidDesc d;
  d.spacing = Real(0.1);
  Fluid& f = w.need<Fluid>();
  const ObjectId water = add_water(w, d, vec3(Real(0.5), Real(0.5), Real(0.5)));
  CHECK(f.clumping(water) == 0);
  const ObjectId pairs = f.add_fluid(d);
  // three on a line: one pair of three is close
  const Vec3 points[] = {vec3(0, 5, 0), vec3(Real(0.04), 5, 0), vec3(Real(0.12), 5, 0)};
  f.fill(pairs, points, Vec3::Zero());
  CHECK(f.clumping(pairs) == Approx(1.0 / 3));
  double row = -1;
  for (const Residual& r : w.residuals())
    if (r.name == "fluid.clumping") row = r.value;
  CHECK(row > 0);
  CHECK(row < 0.01);
  const std::uint64_t before = w.hash();
  f.clumping(water), w.residuals(), w.query<Fluid>()->sample(water, vec3(0, 0, 0));
  CHECK(w.hash() == before);
}

TEST_CASE("questions change nothing", "[fluid]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const auto run_hash = [&](bool asked) {
    World w(fluid_world(2), fluid_catalog());
    add_tank(w, vec3(1, 0, 0));
    FluidDesc d;
    d.solver = solver;
    const ObjectId id = add_water(w, d, vec3(Real(0.4), Real(0.5), 0));
    std::vector<Real> pressures;
    for (int k = 0; k < 40; ++k) {
      w.step();
      if (!asked) continue;
      Fluid& f = *w.query<Fluid>();
      double mean = 0, most = 0;
      f.density_error(id, mean, most);
      f.pressures(id, pressures);
      f.sample(id, vec3(Real(0.2), Real(0.1), 0));
      f.clumping(id);
    }
    return w.hash();
  };
  CHECK(run_hash(false) == run_hash(true));
}
