// Still air: the drag of a world's air_density on cloth and on the faces of nets.
#include <cmath>
#include <cstdio>
#include <random>

#include "cloth/sheets.h"
#include "cloth/still_air.h"
#include "feder/force.h"
#include "forces/area.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("still air eight wide is that of single triangles, added by vertex", "[cloth][air]") {
  constexpr std::uint32_t kPoints = 40, kTriangles = 101;
  std::mt19937 random(3);
  const auto number = [&] { return Real(static_cast<double>(random()) / 2147483648.0 - 1); };
  const auto vector = [&] {
    const Real x = number(), y = number(), z = number();
    return Vec3(x, y, z);
  };
  Arena arena{"air"};
  ClothMesh mesh{arena};
  for (std::uint32_t k = 0; k < kTriangles; ++k) {
    const auto up_to = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    const std::uint32_t a = up_to(kPoints), b = (a + 1 + up_to(19)) % kPoints, c = (b + 1 + up_to(19)) % kPoints;
    for (const std::uint32_t i : {a, b, c}) mesh.triangles.push_back(i);
  }
  std::vector<Vec3> position(kPoints + 1, Vec3::Zero()), wanted(kPoints, Vec3::Zero());
  std::vector<Row4> delta(kPoints + 1, Row4{0, 0, 0, 0}), velocity(delta);
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    position[i] = vector();
    delta[i].set(Real(0.1) * vector()), delta[i].w = i % 3 == 0 ? Real(0) : 1 + number() / 2;
    velocity[i].set(i % 7 == 0 ? Vec3(0, 0, 0) : Vec3(10 * vector()));
  }
  StillAir::Flow flow;
  flow.position = position.data(), flow.delta_position = delta.data(), flow.velocity = velocity.data();
  flow.density = Real(1.2), flow.most = Real(2), flow.drag = Real(0.8), flow.lift = Real(0.4);
  for (std::uint32_t k = 0; k < kTriangles; ++k) {
    const std::uint32_t* v = &mesh.triangles[3 * k];
    const auto at = [&](int n) { return Vec3(position[v[n]] + delta[v[n]].vec()); };
    const Real weight = std::max({delta[v[0]].w, delta[v[1]].w, delta[v[2]].w});
    if (!(weight > 0)) continue;
    const Vec3 u = (velocity[v[0]].vec() + velocity[v[1]].vec() + velocity[v[2]].vec()) / 3;
    const Vec3 force = still_air(u, cross(Vec3(at(1) - at(0)), Vec3(at(2) - at(0))), flow.density, flow.most / weight,
                                 {flow.drag, flow.lift});
    for (int n = 0; n < 3; ++n) wanted[v[n]] += force / 3;
  }
  JobPool jobs;
  std::vector<Vec3> force[2];
  for (const bool wide : {false, true}) {
    StillAir air(arena);
    air.pick(wide);
    air.build(mesh, kPoints, kPoints, 1);
    force[wide].assign(kPoints, Vec3::Zero());
    CHECK(air.meet(flow, force[wide].data(), jobs) > 0);
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      CHECK(double(length(Vec3(force[wide][i] - wanted[i]))) <= 1e-5 * double(length(wanted[i])));
      CHECK(force[wide][i] == force[0][i]);
    }
  }
}

TEST_CASE("a sheet sinks through still air at the speed where drag carries it; wind = false leaves air out",
          "[cloth][air]") {
  const Real density = GENERATE(Real(0), Real(0.6), Real(1.2));
  const bool wind = GENERATE(true, false);
  WorldDesc wd;
  wd.sleeping = false;
  wd.options.set("air_density", static_cast<double>(density));
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(7, 7, 1, 1);
  d.bend = 1;
  d.wind = wind;
  const ObjectId id = cloth.add_cloth(d);
  for (int k = 0; k < 180; ++k) w.step();
  const double speed = -component(cloth.velocity(id, 24), 1);
  CAPTURE(density, wind, speed);
  if (density == 0 || !wind) {
    CHECK(speed == Approx(9.81 * 3).epsilon(1e-4));
    return;
  }
  // area_density g = density v^2 (1 + skin)/2
  CHECK(speed == Approx(std::sqrt(2 * 0.2 * 9.81 / (1.02 * static_cast<double>(density)))).epsilon(0.02));
}

TEST_CASE("drag of light cloth at high speed stops it and never turns it round", "[cloth][air]") {
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, 0, 0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(5, 5, 1, 1);
  d.area_density = Real(0.005);
  d.velocity = Vec3(0, -300, 0);
  const ObjectId id = cloth.add_cloth(d);
  double last = w.energy().kinetic;
  for (int k = 0; k < 30; ++k) {
    w.step();
    CHECK(w.energy().kinetic <= last);
    last = w.energy().kinetic;
  }
  CHECK(component(cloth.velocity(id, 12), 1) < 0);
  CHECK(component(cloth.velocity(id, 12), 1) > -5);
}

// Wind is asked for square metres, drag for vertices; each acts over a substep with what it was at its start.
TEST_CASE("a force against velocity stops light cloth and never turns it round", "[cloth][air]") {
  const std::string kind = GENERATE("wind", "drag");
  const int forces = GENERATE(1, 3);
  const std::string solver = GENERATE("xpbd", "mass_spring");
  CAPTURE(kind, forces, solver);
  WorldDesc wd;
  wd.sleeping = false;
  wd.gravity = Vec3(0, 0, 0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(5, 5, 1, 1);
  d.solver = solver;
  d.area_density = Real(0.005);
  d.velocity = Vec3(0, -300, 0);
  const ObjectId id = cloth.add_cloth(d);
  Params options;
  if (kind == "drag") options.set("linear", 10.0);
  for (int k = 0; k < forces; ++k) {
    ForceEntry on;
    on.all = true;
    w.add_force(kind, options, std::move(on), "", 0);
  }
  const double start = w.energy().kinetic;
  double last = start;
  for (int k = 0; k < 30; ++k) {
    w.step();
    const double now = w.energy().kinetic;
    CHECK(now <= last + 1e-3 * start);  // what was stored as strain comes back
    last = now;
  }
  CHECK(last < 1e-3 * start);
  CHECK(component(cloth.velocity(id, 12), 1) < 1);
  CHECK(component(cloth.velocity(id, 12), 1) > -6);
}

TEST_CASE("a curtain that swings in still air falls asleep within 20 s", "[cloth][air]") {
  const std::uint32_t columns = GENERATE(17u, 25u, 33u);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(columns, columns, 2, 2);
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 3);  // let go at 30 degrees
  d.pin_names = {"top"};
  const ObjectId id = cloth.add_cloth(d);
  int k = 0;
  for (; k < 60 * 20 && !cloth.asleep(id); ++k) {
    w.step();
    if (k % 150 == 149) std::printf("curtain %u, %.1f s: %.5f J\n", columns, w.time(), w.energy().kinetic);
  }
  std::printf("curtain %u asleep after %.1f s\n", columns, w.time());
  CHECK(cloth.asleep(id));
}
