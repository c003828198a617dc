// The contract of fluid solvers, for every row of the table: hydrostatics, momentum, walls that hold, determinism,
// snapshots. A new solver is enrolled by its line alone.
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("a column at rest has the pressure of its weight and keeps its level for ten seconds", "[fluid][contract]") {
  const std::string solver = any_fluid_solver();
  const int dimension = GENERATE(2, 3);
  CAPTURE(solver, dimension);
  if (!kLarge && dimension == 3) return;
  World w(fluid_world(dimension), fluid_catalog());
  const Real spacing = dimension == 2 ? Real(0.04) : Real(0.05);
  const Vec3 size = dimension == 2 ? vec3(Real(0.4), Real(0.6), 0) : vec3(Real(0.4), Real(0.6), Real(0.4));
  add_tank(w, size);
  FluidDesc d;
  d.solver = solver, d.spacing = spacing;
  const ObjectId id = add_water(w, d, size);
  Fluid& f = w.need<Fluid>();
  run(w, 3 * kShare);
  // means over the rest of the time: single moments swing
  double low = 0, middle = 0, level = 0, lowest = 9, highest = 0;
  int n = 0;
  for (double t = 0; t < (dimension == 2 ? 7 : 2) * kShare; t += 0.25) {  // five seconds in all do in 3D
    run(w, 0.25);
    Real y = 0;
    REQUIRE(w.query<Fluid>()->height_at(id, size[0] / 2, size[2] / 2, y));
    low += w.query<Fluid>()->pressure_at(id, vec3(size[0] / 2, Real(0.1), size[2] / 2)),
        middle += w.query<Fluid>()->pressure_at(id, vec3(size[0] / 2, Real(0.3), size[2] / 2));
    level += y, lowest = std::min<double>(lowest, y), highest = std::max<double>(highest, y);
    ++n;
  }
  low /= n, middle /= n, level /= n;
  CHECK(f.particle_count(id) == (dimension == 2 ? 150 : 768));
  if (!kFull) return;
  CHECK(lowest > 0.6 - spacing);
  CHECK(highest < 0.6 + spacing);
  CHECK(low == Approx(9810 * (level - 0.1)).epsilon(0.05));
  CHECK(middle == Approx(9810 * (level - 0.3)).epsilon(0.05));
  // at rest: the kinetic energy of a fall of half a spacing at most
  const double mass = static_cast<double>(f.particle_mass(id)) * static_cast<double>(f.particle_count(id));
  CHECK(w.energy().kinetic < mass * 9.81 * spacing / 2);
}

TEST_CASE("a free blob keeps its momentum", "[fluid][contract]") {
  const std::string solver = any_fluid_solver();
  const int dimension = GENERATE(2, 3);
  CAPTURE(solver, dimension);
  WorldDesc desc = fluid_world(dimension);
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  FluidDesc d;
  d.solver = solver, d.spacing = Real(0.1), d.viscosity = 5, d.surface_tension = 2;
  const Real half = Real(0.5);
  const ObjectId id = add_water(w, d, vec3(1, 1, 1), vec3(-half, -half, -half));
  Fluid& f = w.need<Fluid>();
  std::vector<Vec3> v;
  for (const Vec3& x : places(w, id))  // spins, is squeezed, and moves on
    v.push_back(
        vec3(-2 * x[1] - Real(0.5) * x[0] + 1, 2 * x[0] + Real(0.5) * x[1], dimension == 2 ? Real(0) : Real(0.3)));
  f.set_velocities(id, v);
  const Momentum before = w.momentum();
  run(w, 1 * kShare);
  const Momentum after = w.momentum();
  const double mass = static_cast<double>(f.particle_mass(id)) * static_cast<double>(v.size());
  for (int k = 0; k < 3; ++k) CHECK(after.linear[k] == Approx(before.linear[k]).margin(1e-6 * mass));
  const double share = 1e-4;
  CHECK(after.angular[2] == Approx(before.angular[2]).margin(share * std::abs(before.angular[2])));
  CHECK(std::abs(before.angular[2]) > 0.1);
}

TEST_CASE("no particle leaves a closed box that is shaken", "[fluid][contract]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  World w(fluid_world(3), fluid_catalog());
  Rigid& rigid = w.need<Rigid>();
  const Real in = Real(0.4), wall = Real(0.05), out = in + 2 * wall;
  std::vector<CompoundPart> parts;
  for (int axis = 0; axis < 3; ++axis)
    for (const Real side : {Real(-1), Real(1)}) {
      Vec3 size = vec3(out, out, out), at = Vec3::Zero();
      size[axis] = wall, at[axis] = side * (in + wall) / 2;
      parts.push_back({make_box(size[0], size[1], size[2]), {at, Quat{}}});
    }
  BodyDesc b;
  b.type = BodyType::kinematic;
  b.shape = make_compound(parts);
  const ObjectId box = rigid.add_body(b);
  FluidDesc d;
  d.solver = solver, d.spacing = in / 6;
  const ObjectId id = add_water(w, d, vec3(in, in / 2, in), vec3(-in / 2, -in / 2, -in / 2));
  const std::size_t count = w.need<Fluid>().particle_count(id);
  const int steps = static_cast<int>(600 * (kLarge ? 1 : kShare / 4));
  for (int k = 0; k < steps; ++k) {
    const double t = (k + 1) / 60.0, a = 6.2831853 * 2.5 * t;
    Pose p;  // 0.1 m at 2.5 Hz along a slanted line, turning by 0.6 rad at 1 Hz
    p.position = vec3(Real(0.1 * sin_cos_sin(a)), Real(0.06 * sin_cos_sin(a + 1)), 0);
    p.rotation = from_axis_angle(vec3(0, 0, 1), Real(0.6 * sin_cos_sin(6.2831853 * t)));
    rigid.move_to(box, p);
    w.step();
    if (k % 20 != 0) continue;
    const Pose now = rigid.pose(box);
    for (const Vec3& x : places(w, id)) REQUIRE(to_local(now, x).cwiseAbs().maxCoeff() < in / 2);
  }
  CHECK(w.need<Fluid>().particle_count(id) == count);
  CHECK(w.is_finite());
}

TEST_CASE("threads change nothing, and a snapshot goes on bit for bit", "[fluid][contract][threads]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const auto make = [&](int threads) {
    auto w = std::make_unique<World>(fluid_world(3, threads), fluid_catalog());
    add_tank(*w, vec3(1, 1, Real(0.5)));
    FluidDesc d;
    d.solver = solver, d.spacing = Real(0.05), d.viscosity = 1, d.surface_tension = 1;
    const ObjectId id = add_water(*w, d, vec3(Real(0.5), Real(0.6), Real(0.5)));
    EmitterDesc e;
    e.position = vec3(Real(0.7), Real(0.8), Real(0.2)), e.rate = 200, e.limit = 30;
    w->need<Fluid>().add_emitter(id, e);
    BodyDesc ball;
    ball.shape = make_sphere(Real(0.1)), ball.density = 400, ball.position = vec3(Real(0.3), Real(0.8), Real(0.25));
    w->need<Rigid>().add_body(ball);
    return w;
  };
  const auto one = make(1), two = make(2), four = make(4);
  for (auto* w : {one.get(), two.get(), four.get()}) run(*w, (kLarge ? 0.2 : 0.05) * kShare);
  CHECK(two->hash() == one->hash());
  CHECK(four->hash() == one->hash());
  const std::string image = one->snapshot();
  run(*one, 0.05), run(*four, 0.05);
  const std::uint64_t expected = one->hash();
  CHECK(four->hash() == expected);
  one->restore(image);
  CHECK(one->hash() != expected);
  run(*one, 0.05);
  CHECK(one->hash() == expected);
}

// Enough particles for loops without neighbours to be shared as well; bodies that it moves beside those it does not.
TEST_CASE("threads change nothing where all loops are shared", "[fluid][contract][threads]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  const auto make = [&](int threads) {
    WorldDesc desc = fluid_world(3, threads);
    desc.substeps = 1, desc.dt = Real(0.002);
    auto w = std::make_unique<World>(desc, fluid_catalog());
    add_tank(*w, vec3(1, 1, Real(0.5)));
    FluidDesc d;
    d.solver = solver, d.spacing = Real(0.02), d.viscosity = 1;
    const ObjectId id = add_water(*w, d, vec3(Real(0.5), Real(0.6), Real(0.5)));
    REQUIRE(w->need<Fluid>().particle_count(id) > 18000);
    BodyDesc ball;
    ball.shape = make_sphere(Real(0.1)), ball.density = 400, ball.position = vec3(Real(0.3), Real(0.69), Real(0.25));
    ball.velocity = vec3(0, -2, 0);
    w->need<Rigid>().add_body(ball);
    return w;
  };
  const auto one = make(1), two = make(2), four = make(4);
  for (auto* w : {one.get(), two.get(), four.get()}) run(*w, kFull ? 0.02 : 0.004);
  CHECK(two->hash() == one->hash());
  CHECK(four->hash() == one->hash());
}

TEST_CASE("a step of a fluid that does not grow allocates nothing", "[fluid][contract]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  World w(fluid_world(3), fluid_catalog());
  add_tank(w, vec3(Real(0.5), 1, Real(0.5)));
  FluidDesc d;
  d.solver = solver, d.spacing = Real(0.05), d.viscosity = 1;
  add_water(w, d, vec3(Real(0.5), Real(0.3), Real(0.5)));
  run(w, 1.5);  // until the lattice that it was filled as is none
  const auto before = w.allocations();
  run(w, 0.2);
  CHECK(w.allocations() == before);
}
