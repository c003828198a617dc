// Light sheets hold water: a jet does not pass them, and a hammock carries many times its own weight.
#include <algorithm>
#include <cmath>

#include "couple/fluid_parts.h"
#include "couple/sheet_sides.h"
#include "support/catch.h"

using namespace feder;

namespace {

using Pins = std::vector<std::string>;
const Pins kBorder = {"top", "bottom", "left", "right"},
           kCorners = {"top_left", "top_right", "bottom_left", "bottom_right"}, kFree = {};

// A jet of 80 m/s onto a sheet of 0.2 kg/m2: none of its particles passes.
void check_jet(const std::string& solver, const Pins& pins, int steps) {
  const std::size_t count = kAsserts ? 100 : 1500;
  CAPTURE(solver, pins.size());
  WorldDesc wd;
  wd.dt = Real(1) / 240, wd.substeps = 1;
  World w(wd, mixed_catalog());
  ClothDesc sheet = square(21, 2, false);
  sheet.pin_names = pins, sheet.self_collision = true;
  Cloth& cloth = w.need<Cloth>();
  const ObjectId cid = cloth.add_cloth(sheet);
  Fluid& fluid = w.need<Fluid>();
  FluidDesc d;
  d.solver = solver;
  const ObjectId id = fluid.add_fluid(d);
  EmitterDesc e;
  e.position = Vec3(Real(0.013), Real(0.6), Real(0.027)), e.speed = 80, e.limit = count;
  fluid.add_emitter(id, e);
  SheetSides sides;
  for (int k = 0; k < steps; ++k) {
    w.step();
    sides.follow(cloth, cid, fluid, id);
  }
  CHECK(sides.passed() == 0);
  CHECK(fluid.particle_count(id) == count);
  CHECK(residual(w, "fluid_cloth.impulse_mismatch") < 1e-4);
  CHECK(w.is_finite());
}

}  // namespace

TEST_CASE("no particle of a jet of 80 m/s passes a light sheet", "[couple][fluid][cloth][leak]") {
  check_jet("dfsph", kBorder, 36);
  if (kAsserts) return;
  check_jet("pbf", kCorners, 36);
  check_jet("wcsph", kFree, 36);
}

TEST_CASE("no particle of a jet of 80 m/s passes a light sheet, with any solver and any pins", "[.][map]") {
  for (const char* solver : {"dfsph", "pbf", "wcsph"})
    for (const Pins& pins : {kBorder, kCorners, kFree}) check_jet(solver, pins, 120);
}

namespace {

// A hammock of light cloth carries fifty kilograms of water for five seconds, and it comes to rest there.
void check_hammock(const std::string& solver, Real area_density, int steps) {
  CAPTURE(solver, area_density);
  World w(WorldDesc{}, mixed_catalog());
  ClothDesc sheet = square(17, Real(1.6), false);
  sheet.pin_names = kBorder, sheet.area_density = area_density, sheet.self_collision = true;
  Cloth& cloth = w.need<Cloth>();
  const ObjectId cid = cloth.add_cloth(sheet);
  Fluid& fluid = w.need<Fluid>();
  FluidDesc d;
  d.solver = solver;
  const ObjectId id = fluid.add_fluid(d);
  fluid.fill(id, block(10, 4, 10, d.spacing, Vec3(0, Real(0.13), 0)), Vec3::Zero());
  double speed = 0, shaken = 0;
  std::vector<Vec3> x;
  for (int k = 0; k < steps; ++k) {
    w.step();
    if (k < steps - 60) continue;
    fluid.velocities(id, x);
    double sum = 0, sheet_sum = 0;
    for (const Vec3& u : x) sum += static_cast<double>(dot(u, u));
    for (std::size_t i = 0; i < cloth.vertex_count(cid); ++i)
      sheet_sum += static_cast<double>(dot(cloth.velocity(cid, i), cloth.velocity(cid, i)));
    speed += std::sqrt(sum / static_cast<double>(x.size())) / 60;
    shaken += std::sqrt(sheet_sum / static_cast<double>(cloth.vertex_count(cid))) / 60;
  }
  fluid.positions(id, x);
  Real lowest = 0;
  int below = 0, beside = 0;
  for (std::size_t i = 0; i < cloth.vertex_count(cid); ++i) lowest = std::min(lowest, cloth.point(cid, i)[1]);
  for (const Vec3& q : x) {
    const bool over_rim = std::max(std::abs(q[0]), std::abs(q[2])) > Real(0.8);
    below += q[1] < lowest && !over_rim, beside += over_rim;
  }
  CAPTURE(lowest, speed, shaken, beside, residual(w, "fluid_cloth.guarded"), residual(w, "cloth.max_strain"));
  CHECK(below == 0);
  CHECK(w.is_finite());
  if (steps < 300) return;
  CHECK(beside < 20);
  CHECK(speed < 0.1);
  CHECK(shaken < 0.1);
}

}  // namespace

TEST_CASE("hammocks of light cloth carry fifty kilograms of water", "[couple][fluid][cloth][leak][hammock]") {
  for (const char* solver : {"dfsph", "pbf", "wcsph"})
    for (const Real density : {Real(0.2), Real(0.02)}) check_hammock(solver, density, kAsserts ? 20 : 300);
}
