// What fluids and their couplings say about themselves: every number is made non-zero on purpose, and is what it says.
#include <cmath>
#include <functional>

#include "contact/surface_contact.h"
#include "couple/fluid_parts.h"
#include "couple/surface_rigid.h"
#include "fluid/pool.h"
#include "state/particles.h"
#include "state/solver_bodies.h"

using namespace feder;

namespace {

// Meddles with the state in the middle of a substep: in the stage `advance` behind the fluid's own passes and before
// the couplings look, or between the rows of sheets and their reading back.
class Thief final : public System {
 public:
  static constexpr const char* kName = "thief";
  static const SystemDescriptor& descriptor() {
    static const SystemDescriptor d = {.name = kName, .units = "hands", .make = &make_system<Thief>};
    return d;
  }
  explicit Thief(SystemSetup& s)
      : points(s.store.need<Particles>(Springs::kName)), solver_bodies(s.store.need<SolverBodies>(Rigid::kName)) {}
  void add_passes(StepPlan& plan) override {
    plan.add<&Thief::advance>(before(Rank::boundary_weigh), "steal", kName, this);
    plan.add<&Thief::weigh>(after(Rank::boundary_weigh), "steal before faces", kName, this);
    plan.add<&Thief::unweigh>(after(Rank::net_contact), "give back", kName, this);
    plan.add<&Thief::solve>(before(Rank::surface_collect), "steal from sheets", kName, this);
  }
  std::size_t count() const override { return 0; }
  void hash(Hash&) const override {}
  void save(Writer&) const override {}
  void load(Reader&) override {}

  std::function<void()> in_advance, in_weigh, in_unweigh, in_solve;
  Particles& points;
  SolverBodies& solver_bodies;

 private:
  void advance(StepContext&) {
    if (in_advance) in_advance();
  }
  void weigh(StepContext&) {
    if (in_weigh) in_weigh();
  }
  void unweigh(StepContext&) {
    if (in_unweigh) in_unweigh();
  }
  void solve(StepContext&) {
    if (in_solve) in_solve();
  }
};

Catalog with_thief() {
  static const SystemDescriptor* const list[] = {
      &Collide::descriptor(),      &Rigid::descriptor(),          &Springs::descriptor(),
      &SpringsRigid::descriptor(), &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
      &Cloth::descriptor(),        &ClothRigid::descriptor(),     &Fluid::descriptor(),
      &FluidRigid::descriptor(),   &FluidCloth::descriptor(),     &FluidSprings::descriptor(),
      &Thief::descriptor()};
  return list;
}

// A ball falls into a small tank.
struct Splash {
  explicit Splash(const std::string& solver) : world(waking(), with_thief()), thief(world.need<Thief>()) {
    const auto wall = [&](const Vec3& n, Real at) {
      BodyDesc b;
      b.type = BodyType::fixed, b.shape = make_plane(n, at);
      world.need<Rigid>().add_body(b);
    };
    wall(Vec3(0, 1, 0), 0);
    for (const Real side : {Real(1), Real(-1)}) wall(Vec3(side, 0, 0), Real(-0.2)), wall(Vec3(0, 0, side), Real(-0.2));
    FluidDesc d;
    d.solver = solver, d.viscosity = 1;
    water = fluid().add_fluid(d);
    fluid().fill(water, block(8, 4, 8, d.spacing, Vec3(0, Real(0.1), 0)), Vec3::Zero());
    BodyDesc b;
    b.shape = make_sphere(Real(0.08)), b.density = 600, b.position = Vec3(0, Real(0.35), 0);
    ball = world.need<Rigid>().add_body(b);
  }
  static WorldDesc waking() {
    WorldDesc d;
    d.sleeping = false;
    return d;
  }
  Fluid& fluid() { return world.need<Fluid>(); }
  World world;
  Thief& thief;
  ObjectId water, ball;
};

}  // namespace

TEST_CASE("what leaves a fluid arrives at the bodies, and what is stolen on the way is told",
          "[couple][fluid][residual]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  CAPTURE(solver);
  Splash s(solver);
  double worst = 0, given = 0;
  for (int k = 0; k < 60; ++k) {
    s.world.step();
    worst = std::fmax(worst, residual(s.world, "fluid_rigid.impulse_mismatch"));
    given += residual(s.world, "fluid_rigid.impulse_ns");
  }
  const double weight = 600 * 4.18879 * 0.08 * 0.08 * 0.08 * 9.81;
  CAPTURE(worst, given);
  CHECK(given > 0.3 * weight);  // it floats for most of the second
  CHECK(worst < 1e-4);
  // a gram m/s of one particle in each substep
  FluidPool& p = s.fluid().pool_at(0);
  const double stolen = 1e-3;
  s.thief.in_advance = [&] { p.v[0].y += static_cast<Real>(stolen / static_cast<double>(p.mass)); };
  const double before = residual(s.world, "fluid_rigid.impulse_mismatch");
  s.world.step();
  const double told = residual(s.world, "fluid_rigid.impulse_mismatch");
  // all impulses of a step at rest: the weight of the water on the floor, and the share of it that the walls carry
  const double water = 256 * static_cast<double>(p.mass) * 9.81 / 60;
  CAPTURE(before, told, water);
  CHECK(told > 10 * before);
  CHECK(told < stolen / (0.5 * water));
  CHECK(told > stolen / (4 * water));
}

TEST_CASE("the impulse of a fluid on a body that floats at rest is the body's weight", "[couple][fluid][residual]") {
  Splash s("pbf");
  for (int k = 0; k < 300; ++k) s.world.step();
  double given = 0;
  for (int k = 0; k < 60; ++k) s.world.step(), given += residual(s.world, "fluid_rigid.impulse_ns");
  const double weight = 600 * 4.18879 * 0.08 * 0.08 * 0.08 * 9.81;
  CHECK(given == Approx(weight).epsilon(0.1));
}

TEST_CASE("density errors are those of the particles, lost ones are counted", "[fluid][residual]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"));
  CAPTURE(solver);
  Splash s(solver);
  for (int k = 0; k < 30; ++k) s.world.step();
  CHECK(residual(s.world, "fluid.lost_particles") == 0);
  FluidPool& p = s.fluid().pool_at(0);
  double sum = 0, most = 0;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const double e = std::fmax(0.0, static_cast<double>(p.ratio[i]) - 1);
    sum += e, most = std::fmax(most, e);
  }
  CHECK(most > 0);
  CHECK(residual(s.world, "fluid.density_error_max") == Approx(most));
  CHECK(residual(s.world, "fluid.density_error_mean") == Approx(sum / p.count));
  // and what is asked for anew, where the particles have come to since, is near
  double mean = 0, largest = 0;
  s.world.query<Fluid>()->density_error(s.water, mean, largest);
  CHECK(residual(s.world, "fluid.density_error_mean") == Approx(mean).margin(0.01));
  // two particles come to nothing
  int left = 2;
  s.thief.in_advance = [&] {
    const auto i = static_cast<std::uint32_t>(left);
    // a number of the particle alone: neighbours do not read it
    if (left > 0) (solver == "pbf" ? p.v[i].x : p.lambda[i]) = std::numeric_limits<Real>::quiet_NaN(), --left;
  };
  s.world.step();
  CHECK(residual(s.world, "fluid.lost_particles") == 2);
  CHECK(s.fluid().particle_count(s.water) == 254);
  CHECK_FALSE(s.world.is_finite());
}

TEST_CASE("an impulse that a sheet gets and the fluid does not is told", "[couple][fluid][cloth][residual]") {
  WorldDesc wd;
  wd.gravity = Vec3::Zero();
  World w(wd, with_thief());
  Thief& thief = w.need<Thief>();
  w.need<Cloth>().add_cloth(square(9, 1, true));
  Fluid& fluid = w.need<Fluid>();
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(1, 1, 1, Real(0.05), Vec3(Real(0.03), Real(0.1), Real(0.05))), Vec3(0, -2, 0));
  double told = 0;
  const auto run = [&](double by) {
    thief.in_solve = [&thief, by] {
      if (thief.solver_bodies.state.size() > 1) thief.solver_bodies.state.back().velocity[0] += static_cast<Real>(by);
    };
    for (int k = 0; k < 6; ++k) w.step(), told = std::fmax(told, residual(w, "fluid_cloth.impulse_mismatch"));
  };
  run(0);
  CHECK(told < 1e-4);
  fluid.set_velocities(id, std::vector<Vec3>(1, Vec3(0, -4, 0)));
  run(0.5);
  CHECK(told > 1e-2);
}

TEST_CASE("an impulse that a net's points do not get is told", "[couple][fluid][springs][residual]") {
  const bool steals = GENERATE(false, true);
  WorldDesc wd;
  wd.gravity = Vec3::Zero();
  World w(wd, with_thief());
  Thief& thief = w.need<Thief>();
  w.need<Springs>().add_net(mat(5, 1, 2, 400));
  Fluid& fluid = w.need<Fluid>();
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(1, 1, 1, Real(0.05), Vec3(Real(0.03), Real(0.1), Real(0.05))), Vec3(0, -2, 0));
  if (steals) {  // points are three times as heavy as they let themselves be moved
    thief.in_weigh = [&] {
      for (Real& m : thief.points.mass) m *= 3;
    };
    thief.in_unweigh = [&] {
      for (Real& m : thief.points.mass) m /= 3;
    };
  }
  double told = 0, given = 0;
  for (int k = 0; k < 10; ++k) {
    w.step();
    told = std::fmax(told, residual(w, "fluid_springs.impulse_mismatch"));
    given += residual(w, "fluid_springs.impulse_ns");
  }
  // the particle's momentum is 0.25 N s, the sheet weighs 16 times as much
  CHECK(given > 0.2);
  CHECK(given < 0.5);
  if (steals) {
    CHECK(told > 0.2);
    CHECK(told < 2.1);
  } else {
    CHECK(told < 1e-4);
  }
}

TEST_CASE("particles that a sheet or a net had to hold back are counted", "[couple][fluid][residual]") {
  const bool net = GENERATE(false, true);
  World w(WorldDesc{}, mixed_catalog());
  if (net)
    w.need<Springs>().add_net(mat(11, 2, 10, 4000));
  else
    w.need<Cloth>().add_cloth(square(15, 2, true));
  Fluid& fluid = w.need<Fluid>();
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(5, 5, 5, Real(0.05), Vec3(Real(0.013), Real(0.3), Real(0.027))), Vec3(0, -80, 0));
  double projected = 0;
  for (int k = 0; k < 20; ++k)
    w.step(), projected += residual(w, net ? "fluid_springs.guarded" : "fluid_cloth.guarded");
  CHECK(projected > 0);
  CHECK(projected < 125 * 20);
}
