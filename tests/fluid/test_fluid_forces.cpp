// Forces of the world on fluids: every kind by its law, whom they act on, bookkeeping beside walls, threads, snapshots.
#include <cmath>
#include <map>

#include "feder/force.h"
#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

FluidDesc water(const std::string& solver) {
  FluidDesc d;
  d.solver = solver;
  return d;
}

void act(World& w, const std::string& kind, const Params& options, ObjectId on) {
  ForceEntry target;
  target.target = on;
  w.add_force(kind, options, target, "", 0);
}

Vec3 mean_velocity(World& w, ObjectId id) {
  std::vector<Vec3> v;
  w.need<Fluid>().velocities(id, v);
  Vec3 sum = Vec3::Zero();
  for (const Vec3& u : v) sum += u;
  return sum / static_cast<Real>(v.size());
}

// Options with which a kind pushes a particle at (2, 0, 0) with velocity (0, 1, 0).
Params pushing(const std::string& kind) {
  Params p;
  if (kind == "drag") p.set("linear", 0.02);
  if (kind == "wind") p.set("velocity", std::vector<double>{10, 0, 0});
  if (kind == "buoyancy") p.set("height", 5.0);
  if (kind == "expression") p.set("x", std::string("3*m"));
  return p;
}

}  // namespace

TEST_CASE("every kind of force acts on the fluid it is meant for, and on no other", "[fluid][forces]") {
  const int row = GENERATE(range(0, static_cast<int>(force_kinds().size())));
  const std::string kind = force_kinds()[static_cast<std::size_t>(row)].name, solver = any_fluid_solver();
  CAPTURE(kind, solver);
  World w(weightless(one_substep()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  const Vec3 here[] = {vec3(2, 0, 0)};
  const ObjectId a = f.add_fluid(water(solver)), b = f.add_fluid(water(solver));
  f.fill(a, here, vec3(0, 1, 0)), f.fill(b, here, vec3(0, 1, 0));
  act(w, kind, pushing(kind), a);
  w.step();
  CHECK(length(Vec3(mean_velocity(w, a) - vec3(0, 1, 0))) > Real(1e-5));
  CHECK(length(Vec3(mean_velocity(w, b) - vec3(0, 1, 0))) < Real(1e-5));
}

TEST_CASE("forces on fluids follow their laws", "[fluid][forces]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  World w(weightless(one_substep()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(water(solver));
  const Vec3 here[] = {vec3(2, 0, 0)};
  f.fill(id, here, vec3(0, 1, 0));
  const double m = static_cast<double>(f.particle_mass(id)), t = 60 * w.desc().dt;
  SECTION("a uniform field") {
    Params p;
    p.set("acceleration", std::vector<double>{3, 0, -1});
    act(w, "gravity", p, id);
    const double e = w.energy().potential;
    CHECK(e == Approx(-m * 6).epsilon(1e-2));
    for (int k = 0; k < 60; ++k) w.step();
    CHECK(length(Vec3(mean_velocity(w, id) - vec3(Real(3 * t), 1, Real(-t)))) < Real(1e-3));
    CHECK(w.energy().kinetic + w.energy().potential == Approx(e + 0.5 * m).epsilon(0.01));
  }
  SECTION("linear drag") {
    Params p;
    p.set("linear", m * 4);  // a rate of 4 per second
    act(w, "drag", p, id);
    for (int k = 0; k < 60; ++k) w.step();
    CHECK(mean_velocity(w, id)[1] == Approx(std::exp(-4 * t)).epsilon(0.02));
  }
  SECTION("drag that would turn the velocity round stops it") {
    Params p;
    p.set("linear", 1e9);
    act(w, "drag", p, id);
    w.step();
    CHECK(length(mean_velocity(w, id)) < Real(1e-3));
  }
  SECTION("a spring and a formula swing alike") {
    Params p, q;
    p.set("stiffness", m * 100);
    q.set("x", std::string("-k*x")), q.set("y", std::string("-k*y")), q.set("z", std::string("-k*z"));
    q.set("k", m * 100);
    const ObjectId other = f.add_fluid(water(solver));
    f.fill(other, places(w, id), vec3(0, 1, 0));
    act(w, "spring", p, id), act(w, "expression", q, other);
    for (int k = 0; k < 60; ++k) w.step();
    CHECK(length(Vec3(mean_velocity(w, id) - mean_velocity(w, other))) < Real(0.02));
    CHECK(mean_velocity(w, id)[0] == Approx(-20 * std::sin(10 * t)).margin(0.6));
  }
  SECTION("an attractor pulls with strength r^power") {
    Params p;
    p.set("strength", 8.0);
    act(w, "attractor", p, id);
    w.step();
    CHECK(mean_velocity(w, id)[0] == Approx(-2 * w.desc().dt).epsilon(1e-3));
  }
  SECTION("buoyancy lifts what is lighter than the liquid") {
    Params p;
    p.set("height", 5.0), p.set("density", 1500.0);
    act(w, "buoyancy", p, id);
    w.step();
    CHECK(mean_velocity(w, id)[1] == Approx(1 + 1.5 * 9.81 * w.desc().dt).epsilon(1e-3));
  }
}

TEST_CASE("wind pushes the surface of a fluid: half rho v^2 times the section", "[fluid][forces]") {
  World w(weightless(one_substep()), fluid_catalog());
  const Vec3 size = vec3(Real(0.6), Real(0.8), Real(0.5));
  const ObjectId id = add_water(w, water("pbf"), size);
  Params p;
  p.set("velocity", std::vector<double>{10, 0, 0});
  act(w, "wind", p, id);
  w.step();
  const double push = w.momentum().linear[0] / w.desc().dt, section = 0.8 * 0.5;
  const double sides = 2 * 0.6 * (0.8 + 0.5) + 2 * section;  // rub at 0.02
  CHECK(push == Approx(0.5 * 1.2 * 100 * (section + 0.02 * sides)).epsilon(0.15));
  // a lone drop has its own section
  Fluid& f = w.need<Fluid>();
  const ObjectId drop = f.add_fluid(water("pbf"));
  const Vec3 far[] = {vec3(50, 0, 0)};
  f.fill(drop, far, Vec3::Zero());
  act(w, "wind", p, drop);
  w.step();
  const double mass = static_cast<double>(f.particle_mass(drop));
  CHECK(mean_velocity(w, drop)[0] * mass / w.desc().dt == Approx(0.5 * 1.2 * 100 * 0.05 * 0.05).epsilon(0.02));
}

TEST_CASE("tags pick fluids, and a force that is off does nothing", "[fluid][forces]") {
  World w(weightless(one_substep()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d = water("pbf");
  const ObjectId plain = f.add_fluid(d);
  d.tags = w.objects().tag_bit("wet");
  const ObjectId wet = f.add_fluid(d);
  const Vec3 here[] = {Vec3::Zero()};
  f.fill(plain, here, Vec3::Zero()), f.fill(wet, here, Vec3::Zero());
  ForceEntry target;
  target.tags = d.tags;
  const ObjectId force = w.add_force("gravity", Params(), target, "", 0);
  w.step();
  const Real fallen = mean_velocity(w, wet)[1];
  CHECK(fallen < Real(-0.03));
  CHECK(mean_velocity(w, plain).isZero(0));
  w.set_force_enabled(force, false);
  w.step();
  CHECK(mean_velocity(w, wet)[1] == Approx(fallen));
  w.set_force_enabled(force, true);
  w.objects().set_tags(wet, 0);
  w.step();
  CHECK(mean_velocity(w, wet)[1] == Approx(fallen));
}

TEST_CASE("fluid under forces in a tank: momentum is accounted for, threads and snapshots change nothing",
          "[fluid][forces]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const auto make = [&](int threads) {
    auto w = std::make_unique<World>(fluid_world(3, threads), fluid_catalog());
    add_tank(*w, vec3(Real(0.5), 1, Real(0.5)));
    const ObjectId id = add_water(*w, water(solver), vec3(Real(0.5), Real(0.5), Real(0.5)));
    BodyDesc b;
    b.shape = make_box(Real(0.2), Real(0.2), Real(0.2)), b.position = vec3(Real(0.25), Real(0.7), Real(0.25));
    b.density = 300;
    w->need<Rigid>().add_body(b);
    Params field, formula, air;
    field.set("acceleration", std::vector<double>{4, 0, 1});
    formula.set("x", std::string("m*sin(9*t)*y")), air.set("velocity", std::vector<double>{-20, 0, 0});
    act(*w, "gravity", field, id), act(*w, "expression", formula, id), act(*w, "wind", air, id);
    return w;
  };
  const auto w = make(1), two = make(2);
  const int steps = kFull ? 30 : 4;
  double worst = 0;
  for (int k = 0; k < steps; ++k) {
    w->step(), two->step();
    for (const Residual& r : w->residuals())
      if (r.name == "fluid_rigid.impulse_mismatch") worst = std::fmax(worst, r.value);
    for (const Event& e : w->events().list()) CHECK(e.kind != EventKind::warning);
  }
  CHECK(worst < 1e-3);
  CHECK(w->hash() == two->hash());
  const std::string image = w->snapshot();
  for (int k = 0; k < steps; ++k) w->step();
  const std::uint64_t hash = w->hash();
  const auto before = w->allocations();
  w->step();
  if (kFull) CHECK(w->allocations() == before);  // the first steps still make room
  w->restore(image);
  for (int k = 0; k < steps; ++k) w->step();
  CHECK(w->hash() == hash);
}

TEST_CASE("a column under a force has the pressure of its weight", "[fluid][forces]") {
  // as gravity does it: the same acceleration as a force, in a world without gravity
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  WorldDesc desc = fluid_world(2);
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  add_tank(w, vec3(Real(0.5), 1, 0));
  const ObjectId id = add_water(w, water(solver), vec3(Real(0.5), Real(0.5), 0));
  act(w, "gravity", Params(), id);
  run(w, 3 * kShare);
  if (!kFull) return;
  double pressure = 0;
  for (int k = 0; k < 20; ++k) {
    run(w, 0.1);
    pressure += w.query<Fluid>()->pressure_at(id, vec3(Real(0.25), Real(0.25), 0)) / 20;
  }
  Real y = 0;
  REQUIRE(w.query<Fluid>()->height_at(id, Real(0.25), 0, y));
  CHECK(y == Approx(0.5).margin(0.05));
  CHECK(pressure == Approx(1000 * 9.81 * 0.25).epsilon(0.15));
}

namespace {

double compression(World& w, ObjectId id) {
  double mean = 0, most = 0;
  w.query<Fluid>()->density_error(id, mean, most);
  return mean;
}

bool warns_of_budget(World& w, double seconds) {
  bool said = false;
  for (int k = 0; k < static_cast<int>(seconds / w.desc().dt); ++k) {
    w.step();
    for (const Event& e : w.events().list())
      said = said || (e.kind == EventKind::warning && w.events().warning_code(e) == "fluid_budget");
  }
  return said;
}

}  // namespace

TEST_CASE("a fluid is as stiff as the forces on it ask for, or says that it is not", "[fluid][forces]") {
  const std::string solver = any_fluid_solver(), kind = GENERATE("field", "script", "drop");
  CAPTURE(solver, kind);
  World w(weightless(fluid_world(2)), fluid_catalog());
  FluidDesc d = water(solver);
  d.spacing = Real(0.025);
  const bool drop = kind == "drop";
  const Vec3 size = vec3(Real(0.5), Real(0.5), 0);
  if (!drop) add_tank(w, size);
  const ObjectId id = add_water(w, d, size, drop ? Vec3(-size / 2) : Vec3(Vec3::Zero()));
  Fluid& f = w.need<Fluid>();
  Params p;
  const double a = 200;  // m/s^2, twenty times gravity; of a drop at its rim
  p.set("acceleration", std::vector<double>{0, -a, 0});
  if (kind == "field") act(w, "gravity", p, id);
  if (kind == "drop") {
    Params spring;
    spring.set("stiffness", static_cast<double>(f.particle_mass(id)) * a / 0.25);
    act(w, "spring", spring, id);
  }
  if (kind == "script") {
    const std::vector<Vec3> forces(f.particle_count(id), vec3(0, static_cast<Real>(-a) * f.particle_mass(id), 0));
    f.set_script_forces(id, forces);
  }
  const bool said = warns_of_budget(w, 1.5 * kShare);
  CHECK(w.is_finite());
  if (!kFull) return;
  CHECK_FALSE(said);
  CHECK(compression(w, id) < 0.01);
}

TEST_CASE("a fluid whose substeps do not carry the forces on it says so", "[fluid][forces]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  World w(weightless(fluid_world(2)), fluid_catalog());
  add_tank(w, vec3(Real(0.5), Real(0.5), 0));
  FluidDesc d = water(solver);
  d.spacing = Real(0.025), d.max_substeps = 1;
  const ObjectId id = add_water(w, d, vec3(Real(0.5), Real(0.5), 0));
  Params p;
  p.set("acceleration", std::vector<double>{0, -2000, 0});
  act(w, "gravity", p, id);
  CHECK(warns_of_budget(w, 0.1));
  CHECK(w.is_finite());
}

TEST_CASE("forces of scripts are kept by particle", "[fluid][forces]") {
  World w(weightless(one_substep()), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  const ObjectId id = f.add_fluid(water(any_fluid_solver()));
  const Vec3 points[] = {vec3(3, 0, 0), vec3(0, 0, 0), vec3(1, 0, 0), vec3(2, 0, 0)};
  f.fill(id, points, Vec3::Zero());
  const Real m = f.particle_mass(id);
  const Vec3 forces[] = {vec3(0, 3 * m, 0), vec3(0, 0, 0), vec3(0, m, 0), vec3(0, 2 * m, 0)};
  f.set_script_forces(id, forces);
  const std::string image = w.snapshot();
  const auto check = [&] {
    for (int k = 0; k < 24; ++k) w.step();
    std::vector<Vec3> v, x = places(w, id);
    f.velocities(id, v);
    for (std::size_t i = 0; i < v.size(); ++i) CHECK(v[i][1] == Approx(x[i][0] * Real(0.1)).margin(1e-3));
  };
  check();
  w.restore(image);
  check();
  f.clear_script_forces();
  const Vec3 before = mean_velocity(w, id);
  w.step();
  CHECK(mean_velocity(w, id) == before);
  CHECK_THROWS_AS(f.set_script_forces(id, {forces, 2}), SceneError);
  const Vec3 bad[] = {vec3(NAN, 0, 0), vec3(0, 0, 0), vec3(0, 0, 0), vec3(0, 0, 0)};
  CHECK_THROWS_AS(f.set_script_forces(id, bad), SceneError);
}
