// Light sheets hold water: a jet does not pass them, and a hammock carries many times its own weight.
#include <algorithm>
#include <cmath>

#include "couple/fluid_parts.h"
#include "couple/sheet_sides.h"
#include "support/catch.h"

using namespace feder;

namespace {

using Pins = std::vector<std::string>;
const Pins kAtBorder = {"top", "bottom", "left", "right"},
           kAtCorners = {"top_left", "top_right", "bottom_left", "bottom_right"}, kFree = {};

// A sheet at the origin and a fluid without particles, at small steps.
struct SheetAndFluid {
  SheetAndFluid(const std::string& solver, std::uint32_t n, Real size, const Pins& pins, Real area_density)
      : w(desc(), mixed_catalog()), cloth(w.need<Cloth>()), fluid(w.need<Fluid>()) {
    ClothDesc sheet = square(n, size, false);
    sheet.pin_names = pins, sheet.area_density = area_density, sheet.self_collision = true;
    cid = cloth.add_cloth(sheet);
    water.solver = solver;
    id = fluid.add_fluid(water);
  }
  static WorldDesc desc() {
    WorldDesc d;
    d.dt = Real(1) / 240, d.substeps = 1;
    return d;
  }
  void step() {
    w.step();
    sides.follow(cloth, cid, fluid, id);
  }
  World w;
  Cloth& cloth;
  Fluid& fluid;
  FluidDesc water;
  ObjectId cid, id;
  SheetSides sides;
};

// A jet of 80 m/s onto a sheet of 0.2 kg/m2: none of its particles passes.
void check_jet(const std::string& solver, const Pins& pins, int steps) {
  const std::size_t count = kAsserts ? 100 : 1500;
  CAPTURE(solver, pins.size());
  SheetAndFluid s(solver, 21, 2, pins, ClothDesc().area_density);
  EmitterDesc e;
  e.position = Vec3(Real(0.013), Real(0.6), Real(0.027)), e.speed = 80, e.limit = count;
  s.fluid.add_emitter(s.id, e);
  for (int k = 0; k < steps; ++k) s.step();
  CHECK(s.sides.passed() == 0);
  CHECK(s.fluid.particle_count(s.id) == count);
  CHECK(residual(s.w, "fluid_cloth.impulse_mismatch") < 1e-4);
  CHECK(s.w.is_finite());
}

}  // namespace

TEST_CASE("no particle of a jet of 80 m/s passes a light sheet", "[couple][fluid][cloth][leak]") {
  check_jet("dfsph", kAtBorder, 36);
}

TEST_CASE("no particle of a jet of 80 m/s passes a light sheet: pbf and wcsph", "[couple][fluid][cloth][leak][heavy]") {
  check_jet("pbf", kAtCorners, 36);
  check_jet("wcsph", kFree, 36);
}

TEST_CASE("no particle of a jet of 80 m/s passes a light sheet, with any solver and any pins", "[.][map]") {
  for (const char* solver : {"dfsph", "pbf", "wcsph"})
    for (const Pins& pins : {kAtBorder, kAtCorners, kFree}) check_jet(solver, pins, 120);
}

namespace {

// A hammock of light cloth carries fifty kilograms of water, which fall into it: nothing passes it, no energy is made,
// and in the end the water lies still, but for what was spilled over the rim. On the lightest pbf shakes, and wcsph,
// whose pressure is explicit, makes energy on 0.2 kg/m2 (22 J above the start after 5 s), some 12 W, and shakes at 1.1
// m/s.
void check_hammock(const std::string& solver, Real area_density, double seconds) {
  CAPTURE(solver, area_density);
  SheetAndFluid s(solver, 17, Real(1.6), kAtBorder, area_density);
  World& w = s.w;
  s.fluid.fill(s.id, block(10, 4, 10, s.water.spacing, Vec3(0, Real(0.13), 0)), Vec3::Zero());
  const auto all = [&] {
    const Energy e = w.energy();
    return e.kinetic + e.potential + e.elastic;
  };
  const double first = all(), mass = 400 * static_cast<double>(s.fluid.particle_mass(s.id));
  const int steps = static_cast<int>(seconds * 240), last = steps * 4 / 5;
  double most = first, speed = 0;
  std::vector<Vec3> x, v;
  std::size_t spilled = 0;
  for (int k = 0; k < steps; ++k) {
    s.step();
    most = std::max(most, all());
    if (k < last) continue;
    s.fluid.positions(s.id, x), s.fluid.velocities(s.id, v);
    double sum = 0;
    spilled = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (std::max(std::abs(x[i][0]), std::abs(x[i][2])) > Real(0.75))
        ++spilled;
      else
        sum += static_cast<double>(dot(v[i], v[i]));
    speed += std::sqrt(sum / static_cast<double>(x.size())) / (steps - last);
  }
  CAPTURE(speed, spilled, most - first, residual(w, "cloth.max_strain"));
  CHECK(s.sides.passed() == 0);
  const bool shakes = solver == "wcsph";
  CHECK(most - first < (shakes ? 0.8 : 0.02) * mass);  // of a fall of 2 mm
  CHECK(w.is_finite());
  if (seconds < 5) return;
  CHECK(spilled < (shakes ? 160 : 120));
  CHECK(speed < (solver == "dfsph" ? 0.15 : shakes ? 1.3 : 0.7));  // m/s, rms
}

}  // namespace

TEST_CASE("a hammock of light cloth carries fifty kilograms of water", "[couple][fluid][cloth][leak]") {
  check_hammock("dfsph", Real(0.02), kAsserts ? 0.1 : 0.7);
  if (!kAsserts) check_hammock("dfsph", Real(0.2), 0.7);
}

TEST_CASE("hammocks of light cloth carry fifty kilograms of water, with any solver", "[.][map]") {
  for (const char* solver : {"dfsph", "pbf", "wcsph"})
    for (const Real density : {Real(2), Real(0.2), Real(0.02)}) check_hammock(solver, density, 5);
}
