// Fluids that do not go well with one another, with a body, or with their tank: one warning each, and none without
// need.
#include "fluid/tank.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Messages of a warning in some steps.
std::vector<std::string> told(World& w, const std::string& code, int steps) {
  std::vector<std::string> found;
  for (int k = 0; k < steps; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == code)
        found.push_back(w.events().warning_message(e));
  }
  return found;
}

FluidDesc named(const char* name, Real spacing, Real density) {
  FluidDesc d;
  d.name = name, d.spacing = spacing, d.density = density;
  return d;
}

}  // namespace

TEST_CASE("fluids of different spacing are warned of once, when they touch", "[fluid][misfits]") {
  WorldDesc desc = fluid_world();
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  const Vec3 size = vec3(Real(0.4), Real(0.4), Real(0.4));
  add_water(w, named("water", Real(0.05), 1000), size);
  const ObjectId oil = add_water(w, named("oil", Real(0.1), 800), size, vec3(1, 0, 0));
  CHECK(told(w, "fluid_spacing", 5).empty());  // apart
  const std::vector<Vec3> v(w.need<Fluid>().particle_count(oil), vec3(-3, 0, 0));
  w.need<Fluid>().set_velocities(oil, v);
  const auto warned = told(w, "fluid_spacing", 40);
  REQUIRE(warned.size() == 1);
  CHECK(warned[0] ==
        "fluid \"oil\" with a spacing of 0.1 m touches fluid \"water\" with 0.05: particles more than 1.25 times as "
        "wide as others are not solved as one with them, and pass through; bring the spacings nearer to each other");
  CHECK(told(w, "density_ratio", 5).empty());
}

TEST_CASE("fluids of one spacing, or that do not collide, may touch", "[fluid][misfits]") {
  World w(fluid_world(), fluid_catalog());
  const Vec3 size = vec3(Real(0.4), Real(0.4), Real(0.4));
  add_water(w, named("a", Real(0.05), 1000), size);
  add_water(w, named("b", Real(0.05), 700), size, vec3(Real(0.4), 0, 0));
  FluidDesc d = named("c", Real(0.1), 700);
  d.group = 2, d.mask = 2;
  add_water(w, d, size, vec3(0, Real(0.4), 0));
  CHECK(told(w, "fluid_spacing", 3).empty());
}

TEST_CASE("a ratio of a million between densities is warned of once", "[fluid][misfits]") {
  WorldDesc desc = fluid_world();
  desc.gravity = Vec3::Zero();
  World w(desc, fluid_catalog());
  add_water(w, named("water", Real(0.1), 1000), vec3(Real(0.4), Real(0.4), Real(0.4)));
  SECTION("of two fluids") {
    add_water(w, named("gas", Real(0.1), Real(1e-3)), vec3(Real(0.4), Real(0.4), Real(0.4)), vec3(Real(0.4), 0, 0));
    const auto warned = told(w, "density_ratio", 5);
    REQUIRE(warned.size() == 1);
    CHECK(warned[0] ==
          "fluid \"gas\" with a density of 0.001 kg/m3 touches fluid \"water\" with 1000: with dfsph "
          "a ratio of more than 1000 throws the lighter one about; bring the densities nearer to each other");
  }
  SECTION("of a body and a fluid") {
    BodyDesc b;
    b.name = "balloon", b.shape = make_box(1, 1, 1), b.density = Real(1e-3), b.position = vec3(0, 3, 0);
    w.need<Rigid>().add_body(b);
    b.name = "cork", b.density = 200, b.position = vec3(0, 5, 0);
    w.need<Rigid>().add_body(b);
    auto warned = told(w, "density_ratio", 5);
    REQUIRE(warned.size() == 1);
    CHECK(warned[0].find("body \"balloon\" has a density of 0.001 kg/m3, fluid \"water\" of 1000: a ratio of more") ==
          0);
    b.name = "anvil", b.density = Real(1e9), b.position = vec3(0, 9, 0);
    w.need<Rigid>().add_body(b);
    warned = told(w, "density_ratio", 5);
    REQUIRE(warned.size() == 1);
    CHECK(warned[0].find("body \"anvil\"") == 0);
  }
}

TEST_CASE("a fill that is a little narrower than the spacing is warned of once", "[fluid][misfits]") {
  World w(fluid_world(), fluid_catalog());
  add_water(w, named("water", Real(0.1), 1000), vec3(1, Real(0.08), 1));
  const auto warned = told(w, "fluid_narrow", 5);
  REQUIRE(warned.size() == 1);
  CHECK(warned[0].find("fluid \"water\" with a spacing of 0.1 m was filled into a shape that is 0.08 m wide: ") == 0);
  add_water(w, named("more", Real(0.1), 1000), vec3(1, Real(0.1), 1), vec3(0, 3, 0));
  CHECK(told(w, "fluid_narrow", 5).empty());
}

TEST_CASE("a tank that is narrower than the spacing is warned of", "[fluid][misfits]") {
  const bool narrow = GENERATE(true, false);
  World w(fluid_world(2), fluid_catalog());
  add_tank(w, vec3(narrow ? Real(0.04) : Real(0.12), 1, 0));
  FluidDesc d = named("water", Real(0.1), 1000);
  const ObjectId id = w.need<Fluid>().add_fluid(d);
  std::vector<Vec3> points;
  for (int k = 0; k < 6; ++k) points.push_back(vec3(Real(0.02), Real(0.05) + Real(0.1) * static_cast<Real>(k), 0));
  w.need<Fluid>().fill(id, points, Vec3::Zero());
  const auto warned = told(w, "fluid_narrow", 10);
  CHECK(warned.size() == (narrow ? 1 : 0));
  if (narrow)
    CHECK(warned[0] ==
          "fluid \"water\" has a spacing of 0.1 m, but lies between walls that are 0.04 m apart: take a "
          "smaller spacing or a wider tank");
  CHECK(w.is_finite());
}

TEST_CASE("more tension between two fluids than both have is told", "[fluid][misfits]") {
  World w(fluid_world(2), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.surface_tension = Real(0.25);
  const ObjectId a = f.add_fluid(d), b = f.add_fluid(d);
  f.fill(a, std::vector<Vec3>{Vec3::Zero()}, Vec3::Zero());
  f.set_interface(a, b, Real(0.5));
  CHECK(told(w, "interface_tension", 1).empty());
  f.set_interface(a, b, Real(0.75));
  CHECK(told(w, "interface_tension", 1).size() == 1);
}
