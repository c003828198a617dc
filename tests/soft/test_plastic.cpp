// Plastic flow of soft bodies against its closed form: elastic strain decays to the yield, what has flowed stays.
#include "soft_bodies.h"

namespace feder::test {
namespace {

constexpr double kYield = 0.05, kFlow = 4, kStretch = 0.25;

std::string flowing_solver() { return GENERATE("xpbd", "vbd", "implicit"); }

// All of a block held where it is stretched along x, its volume kept.
ObjectId add_stretched(World& w, const std::string& solver) {
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 3);
  d.solver = solver, d.yield = static_cast<Real>(kYield), d.flow = static_cast<Real>(kFlow);
  const ObjectId id = soft.add_soft(d);
  const Real along = static_cast<Real>(1 + kStretch), across = static_cast<Real>(1 / std::sqrt(1 + kStretch));
  for (std::size_t i = 0; i < soft.point_count(id); ++i) {
    const Vec3 x = soft.rest_point(id, i);
    soft.pin(id, i), soft.set_point(id, i, Vec3(along * x[0], across * x[1], across * x[2]));
  }
  return id;
}

}  // namespace

TEST_CASE("held in a stretch, elastic strain decays to the yield; let go, what has flowed stays", "[soft][plastic]") {
  const std::string solver = flowing_solver();
  CAPTURE(solver);
  World w(weightless(), catalog());
  const ObjectId id = add_stretched(w, solver);
  Soft& soft = w.need<Soft>();
  double elastic = std::log(1 + kStretch);
  for (int k = 0; k < 30; ++k) {
    const double energy = w.energy().elastic;
    w.step();
    elastic = kYield + (elastic - kYield) / (1 + kFlow / 60);
    CHECK(number(soft.max_strain(id)) == Approx(std::exp(elastic) - 1).epsilon(1e-4));
    CHECK(w.energy().elastic < energy);
  }
  for (std::size_t i = 0; i < soft.point_count(id); ++i) soft.unpin(id, i);
  settle(w, 3, 1e-3);
  CHECK(side(soft, id, 0) == Approx(0.2 * (1 + kStretch) / std::exp(elastic)).epsilon(0.005));
  CHECK(number(soft.volume(id)) == Approx(number(soft.rest_volume(id))).epsilon(0.002));
  CHECK(number(soft.max_strain(id)) < 0.005);
}

TEST_CASE("strain below the yield does not flow, and without one nothing is kept", "[soft][plastic]") {
  World w(weightless(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 3);
  d.damping = Real(0.01);
  std::string images[2];
  for (std::string& image : images) {
    const ObjectId id = soft.add_soft(d);
    for (std::size_t i = 0; i < soft.point_count(id); ++i)
      soft.set_point(id, i, Real(1.05) * soft.rest_point(id, i));  // no shear
    settle(w, 1, 1e-3);
    CHECK(side(soft, id, 0) == Approx(0.2).epsilon(1e-4));
    image = w.snapshot();
    soft.destroy_soft(id, "here");
    d.yield = Real(0.02), d.flow = 10;
  }
  CHECK(images[0].size() < images[1].size());
}

TEST_CASE("flow goes on from a snapshot, on any number of threads", "[soft][plastic][threads]") {
  const std::string solver = flowing_solver();
  CAPTURE(solver);
  std::uint64_t hashes[3];
  for (int k = 0; k < 3; ++k) {
    WorldDesc desc;
    desc.threads = k == 1 ? 4 : 1;
    World w(desc, catalog());
    BodyDesc ground;
    ground.type = BodyType::fixed;
    ground.shape = make_plane(Vec3(0, 1, 0), 0);
    w.need<Rigid>().add_body(ground);
    SoftDesc d = soft_box(vec3(Real(0.3), Real(0.3), Real(0.3)), 4);
    d.solver = solver, d.young = Real(2e4), d.yield = Real(0.02), d.flow = 20;
    d.pose.position = vec3(0, Real(0.4), 0), d.velocity = Vec3(0, -3, 0);
    w.need<Soft>().add_soft(d);
    for (int i = 0; i < 12; ++i) w.step();
    if (k == 2) {
      const std::string image = w.snapshot();
      for (int i = 0; i < 10; ++i) w.step();
      w.restore(image);
    }
    for (int i = 0; i < 12; ++i) w.step();
    hashes[k] = w.hash();
  }
  CHECK(hashes[0] == hashes[1]);
  CHECK(hashes[0] == hashes[2]);
}

TEST_CASE("what flows to a third of its thickness is elastic from there, and says so", "[soft][plastic]") {
  World w(weightless(), catalog());
  Soft& soft = w.need<Soft>();
  SoftDesc d = soft_box(vec3(Real(0.2), Real(0.2), Real(0.2)), 2);
  d.yield = Real(0.01), d.flow = 100;
  const ObjectId id = soft.add_soft(d);
  std::size_t warned = 0;
  for (int k = 0; k < 120; ++k) {
    const Real thin = static_cast<Real>(1 / (1 + 0.05 * k)), wide = std::sqrt(1 / thin);
    for (std::size_t i = 0; i < soft.point_count(id); ++i) {
      const Vec3 x = soft.rest_point(id, i);
      soft.pin(id, i), soft.set_point(id, i, Vec3(wide * x[0], thin * x[1], wide * x[2]));
    }
    w.step();
    warned += count_warnings(w, "plastic_limit");
  }
  CHECK(warned == 1);
  for (std::size_t i = 0; i < soft.point_count(id); ++i) soft.unpin(id, i);
  for (int k = 0; k < 120; ++k) w.step();
  CHECK(w.is_finite());
  CHECK(side(soft, id, 1) > 0.2 / 3.3);
  CHECK(side(soft, id, 1) < 0.2 / 2);
}

TEST_CASE("springs have no shapes that flow: an error that names the solvers that do", "[soft][plastic]") {
  World w(WorldDesc{}, catalog());
  SoftDesc d = soft_box(Vec3(1, 1, 1), 2);
  d.solver = "mass_spring", d.yield = Real(0.1), d.flow = 1;
  CHECK_THROWS_WITH(w.need<Soft>().add_soft(d),
                    Catch::Contains("plastic: expected a solver") && Catch::Contains("xpbd, vbd and implicit"));
  d.flow = -1;
  CHECK_THROWS_WITH(w.need<Soft>().add_soft(d), Catch::Contains("plastic.flow: expected"));
  d.flow = 1, d.yield = -1;
  CHECK_THROWS_WITH(w.need<Soft>().add_soft(d), Catch::Contains("plastic.yield: expected"));
  d.yield = 0, d.solver = "xpbd", d.fracture_stress = 0;
  CHECK_THROWS_WITH(w.need<Soft>().add_soft(d), Catch::Contains("fracture_stress: expected a number above 0"));
  CHECK(w.need<Soft>().soft_count() == 0);
}

}  // namespace feder::test
