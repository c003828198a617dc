// Fluids that share no body take their own substeps; those that press on one body take them together.
#include "fluid/any_solver.h"
#include "fluid/tank.h"

using namespace feder;

namespace {

constexpr Real kSpacing = Real(0.05);

// A calm pool of 8 x 4 x 8 particles, and behind a wall water that runs along the same channel.
struct Two {
  explicit Two(const std::string& solver, bool other, int threads = 1) : w(one_substep(threads), fluid_catalog()) {
    const Real width = 8 * kSpacing;
    add_tank(w, vec3(30, 0, width));
    BodyDesc wall;
    wall.type = BodyType::fixed;
    wall.shape = make_box(Real(0.1), Real(0.2), 1);
    wall.position = vec3(width + Real(0.05), Real(0.1), Real(0.2));
    w.need<Rigid>().add_body(wall);
    FluidDesc d;
    d.solver = solver, d.spacing = kSpacing;
    calm = add_water(w, d, vec3(width, 4 * kSpacing, width));
    if (!other) return;
    fast = w.need<Fluid>().add_fluid(d);
    std::vector<Vec3> points;
    for (int i = 0; i < 64; ++i)
      points.push_back(kSpacing * vec3(static_cast<Real>(i % 4) + 100, static_cast<Real>(i / 16) + Real(0.5),
                                       static_cast<Real>(i / 4 % 4) + Real(0.5)));
    w.need<Fluid>().fill(fast, points, vec3(25, 0, 0));
  }
  std::uint64_t taken(ObjectId id) { return w.need<Fluid>().solver_substeps(id); }
  World w;
  ObjectId calm, fast;
};

}  // namespace

TEST_CASE("a fluid takes the substeps it wants, whatever another one wants elsewhere", "[fluid][groups]") {
  const std::string solver = any_fluid_solver();
  CAPTURE(solver);
  Two alone(solver, false), both(solver, true);
  for (int k = 0; k < 30; ++k) alone.w.step(), both.w.step();
  CHECK(both.taken(both.calm) == alone.taken(alone.calm));
  CHECK(both.taken(both.fast) > both.taken(both.calm));
  CHECK(places(both.w, both.calm) == places(alone.w, alone.calm));  // to the bit
}

TEST_CASE("fluids that press on one body take their substeps together", "[fluid][groups]") {
  Two both("pbf", true);
  const bool joins = GENERATE(false, true);
  CAPTURE(joins);
  BodyDesc beam;  // over both
  beam.shape = make_box(14, Real(0.1), Real(0.2));
  beam.density = 300;
  beam.position = vec3(Real(7.1), joins ? Real(0.27) : Real(3), Real(0.2));
  both.w.need<Rigid>().add_body(beam);
  for (int k = 0; k < 10; ++k) both.w.step();
  CHECK((both.taken(both.calm) == both.taken(both.fast)) == joins);
  CHECK(both.w.is_finite());
}

TEST_CASE("groups of fluids give the same on any number of threads, and after a restore", "[fluid][groups][threads]") {
  const std::string solver = any_fluid_solver();
  const int threads = GENERATE(2, 4);
  CAPTURE(solver, threads);
  Two one(solver, true), many(solver, true, threads);
  for (int k = 0; k < 10; ++k) one.w.step(), many.w.step();
  CHECK(one.w.hash() == many.w.hash());
  const std::string image = one.w.snapshot();
  for (int k = 0; k < 5; ++k) one.w.step();
  const std::uint64_t hash = one.w.hash();
  one.w.restore(image);
  for (int k = 0; k < 5; ++k) one.w.step();
  CHECK(one.w.hash() == hash);
}
