// Still air: the drag of a world's air_density on cloth and on the faces of nets.
#include <cmath>
#include <cstdio>

#include "cloth/sheets.h"
#include "feder/force.h"

using namespace feder;
using namespace feder::test;

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
