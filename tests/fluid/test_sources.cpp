// Filling, emitters, drains, refused input, absence.
#include <cmath>

#include "fluid/any_solver.h"
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

int count_events(World& w, EventKind kind, std::uint32_t* index = nullptr) {
  int n = 0;
  for (const Event& e : w.events().list()) {
    if (e.kind != kind) continue;
    ++n;
    if (index) *index = e.index;
  }
  return n;
}

}  // namespace

TEST_CASE("an emitter gives its rate exactly, stops at its limit and says so once", "[fluid]") {
  WorldDesc desc = fluid_world();
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = Real(0.05);
  const ObjectId id = f.add_fluid(d);
  EmitterDesc e;
  e.position = vec3(0, 1, 0), e.direction = vec3(1, 0, 0), e.speed = 2, e.radius = Real(0.12), e.rate = 300,
  e.limit = 100;
  const ObjectId hose = f.add_emitter(id, e);
  for (int k = 1; k <= 12; ++k) {
    w.step();
    CHECK(std::abs(static_cast<double>(f.particle_count(id)) - 5.0 * k) <= 1);
  }
  f.set_running(hose, false);
  run(w, 0.1);
  CHECK(f.particle_count(id) <= 61);
  f.set_running(hose, true);
  int done = 0;
  std::uint32_t count = 0;
  for (int k = 0; k < 20; ++k) {
    w.step();
    done += count_events(w, kEmitterDone, &count);
  }
  CHECK(done == 1);
  CHECK(count == 100);
  CHECK(f.particle_count(id) == 100);
  CHECK_FALSE(f.running(hose));
  // nothing but their speed moves them, and none lies on another
  const std::vector<Vec3> x = places(w, id);
  double nearest = 9;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) nearest = std::min<double>(nearest, length(Vec3(x[i] - x[j])));
  CHECK(nearest > 0.5 * 0.05);
  CHECK(w.momentum().linear[0] == Approx(100 * 2 * static_cast<double>(f.particle_mass(id))).epsilon(1e-4));
}

TEST_CASE("a full jet has the density of the fluid", "[fluid]") {
  WorldDesc desc = fluid_world(2);
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = Real(0.05);
  const ObjectId id = f.add_fluid(d);
  EmitterDesc e;
  e.direction = vec3(1, 0, 0), e.speed = 3, e.radius = Real(0.2);
  f.add_emitter(id, e);
  run(w, 0.5);
  CHECK(static_cast<double>(f.particle_count(id)) == Approx(9 * 0.5 * 3 / 0.05).margin(10));
  double mean = 0, most = 0;
  w.query<Fluid>()->density_error(id, mean, most);
  CHECK(most < 0.04);  // pbf aims at 0.05
}

TEST_CASE("fluids begin and end contacts with bodies and hit them", "[fluid]") {
  World w(fluid_world(2), fluid_catalog());
  w.events().set_wanted(EventKind::hit, true);
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = make_box(4, Real(0.2), 1)->section(), b.name = "table";
  const ObjectId table = w.need<Rigid>().add_body(b);
  FluidDesc d;
  d.spacing = Real(0.05), d.solver = GENERATE("pbf", "wcsph");
  CAPTURE(d.solver);
  const ObjectId id = add_water(w, d, vec3(Real(0.3), Real(0.3), 0), vec3(0, Real(0.5), 0));
  int begun = 0, ended = 0, hit = 0;
  const auto look = [&] {
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end && e.kind != EventKind::hit) continue;
      CHECK(e.a == table);
      CHECK(e.b == id);
      begun += e.kind == EventKind::contact_begin, ended += e.kind == EventKind::contact_end;
      if (e.kind != EventKind::hit) continue;
      ++hit;
      CHECK(e.index >= 6);  // the lowest layer
      CHECK(e.speed == Approx(std::sqrt(2 * 9.81 * 0.4)).epsilon(0.1));
      CHECK(e.normal[1] > Real(0.9));
      CHECK(e.point[1] < Real(0.2));
    }
  };
  for (int k = 0; k < 30; ++k) w.step(), look();
  CHECK(begun == 1);
  CHECK(hit == 1);
  CHECK(ended == 0);
  w.need<Fluid>().destroy_fluid(id, "here");
  w.step(), look();
  CHECK(ended == 1);
}

TEST_CASE("a drain takes what comes in and counts it", "[fluid]") {
  World w(fluid_world(2), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = Real(0.1);
  const ObjectId id = add_water(w, d, vec3(1, 1, 0), vec3(0, 1, 0));
  Pose pose;
  pose.position = vec3(0, -1, 0);
  const ObjectId drain = f.add_drain(id, "", 0, make_box(10, 2, 1)->section(), pose);
  std::uint32_t taken = 0, total = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    if (count_events(w, kDrained, &taken)) total += taken;
  }
  CHECK(total == 100);
  CHECK(f.passed(drain) == 100);
  CHECK(f.particle_count(id) == 0);
}

TEST_CASE("below its kill height a fluid ends, and an emitter goes on with the room", "[fluid]") {
  World w(fluid_world(3), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = Real(0.1), d.kill_height = -1, d.max_particles = 120, d.solver = any_fluid_solver();
  CAPTURE(d.solver);
  const ObjectId id = add_water(w, d, vec3(Real(0.4), Real(0.4), Real(0.4)));
  d.kill_height = -kInfinity;
  const ObjectId other = add_water(w, d, vec3(Real(0.2), Real(0.2), Real(0.2)), vec3(5, 0, 0));
  EmitterDesc e;
  e.position = vec3(0, 1, 0), e.radius = Real(0.1), e.speed = 1;
  const ObjectId hose = f.add_emitter(id, e);
  const auto look = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      w.step();
      for (const Vec3& x : places(w, id)) CHECK(x[1] >= -1);
      CHECK(f.particle_count(id) <= 120);
    }
  };
  look(60);
  const std::string image = w.snapshot();
  const std::uint64_t emitted = f.passed(hose);
  look(120);
  CHECK(f.passed(hose) > emitted + 60);  // 64 + 60 + 60 are more than may be there at once
  CHECK(f.particle_count(id) < 64 + f.passed(hose));
  CHECK(f.particle_count(other) == 8);
  const std::uint64_t hash = w.hash();
  w.restore(image);
  CHECK(f.passed(hose) == emitted);
  look(120);
  CHECK(w.hash() == hash);
  look(240);  // until the jet has had all its forms
  const auto allocations = w.allocations();
  look(120);
  CHECK(w.allocations() == allocations);
  FluidDesc bad;
  bad.kill_height = kInfinity;
  CHECK_THROWS_WITH(f.add_fluid(bad), Catch::Contains("kill_height"));
}

TEST_CASE("bad input is refused and changes nothing", "[fluid]") {
  World w(fluid_world(), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc bad;
  bad.spacing = std::nanf("");
  CHECK_THROWS_AS(f.add_fluid(bad), SceneError);
  bad = {}, bad.density = 0;
  CHECK_THROWS_AS(f.add_fluid(bad), SceneError);
  bad = {}, bad.kernel = "cubicc";
  CHECK_THROWS_WITH(f.add_fluid(bad), Catch::Contains("known: "));
  bad = {}, bad.solver = "magic";
  CHECK_THROWS_WITH(f.add_fluid(bad), Catch::Contains("known: "));
  FluidDesc d;
  d.max_particles = 50;
  const ObjectId id = f.add_fluid(d);
  const Vec3 nowhere[] = {vec3(0, 0, 0), vec3(0, std::nanf(""), 0)};
  CHECK_THROWS_AS(f.fill(id, nowhere, Vec3::Zero()), SceneError);
  CHECK_THROWS_AS(f.fill(id, *make_box(1, 1, 1), Pose{}, Vec3::Zero()), SceneError);
  CHECK(f.particle_count(id) == 0);
  CHECK(f.fill(id, {nowhere, 1}, Vec3::Zero()) == 1);
  const Vec3 fast[] = {vec3(kInfinity, 0, 0)};
  CHECK_THROWS_AS(f.set_velocities(id, fast), SceneError);
  EmitterDesc e;
  e.speed = -1;
  CHECK_THROWS_AS(f.add_emitter(id, e), SceneError);
  e = {}, e.rate = Real(1e9);
  CHECK_THROWS_WITH(f.add_emitter(id, e), Catch::Contains("particles per second"));
  // more particles across the nozzle than the fluid may have; lattices that no int counts
  for (const Real radius : {Real(10), Real(1000), Real(1e8), Real(1e30)}) {
    e.rate = 0, e.radius = radius;
    CHECK_THROWS_WITH(f.add_emitter(id, e), Catch::Contains("max_particles"));
  }
  // no room for a single particle along one axis
  CHECK_THROWS_WITH(f.fill(id, *make_box(1, Real(0.02), 1), Pose{}, Vec3::Zero()),
                    Catch::Contains("0.02 m wide along y, narrower than the spacing of 0.05 m: take a smaller"));
  CHECK_THROWS_WITH(f.fill(id, *make_sphere(Real(0.01)), Pose{}, Vec3::Zero()), Catch::Contains("narrower than"));
  CHECK_THROWS_WITH(f.fill(id, *make_box(20, 20, 20), Pose{}, Vec3::Zero()), Catch::Contains("max_particles"));
  w.step();
  CHECK(w.is_finite());
}

TEST_CASE("a world without fluid has no rows and no bytes of it", "[fluid]") {
  World w(fluid_world(), fluid_catalog());
  add_plane(w, vec3(0, 1, 0), 0);
  w.step();
  for (const PlanNode& row : w.plan().nodes()) CHECK(std::string(row.system).find("fluid") == std::string::npos);
  for (const auto& arena : w.store().arenas()) CHECK(arena->name() != "fluid");
  // made, but empty: no rows yet
  w.need<Fluid>().add_fluid({});
  w.step();
  std::size_t rows = 0;
  for (const PlanNode& row : w.plan().nodes()) rows += std::string(row.system) == "fluid";
  CHECK(rows == 0);
}
