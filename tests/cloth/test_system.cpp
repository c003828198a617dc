// The cloth system beside its solvers: input, pins, tearing, sleep, snapshots, threads, memory, extremes.
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "cloth/extremes.h"
#include "cloth/mesh.h"
#include "cloth/sheets.h"
#include "state/cloth_vertices.h"

using namespace feder;
using namespace feder::test;

namespace {

const char* any_solver() {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  return cloth_solvers()[static_cast<std::size_t>(row)].name;
}

std::string refusal(const ClothDesc& d) {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const std::uint64_t before = w.hash();
  try {
    cloth.add_cloth(d);
  } catch (const SceneError& e) {
    CHECK(w.hash() == before);
    CHECK(cloth.cloth_count() == 0);
    return e.what();
  }
  return "";
}

ClothDesc mesh(std::vector<Vec3> vertices, std::vector<std::uint32_t> triangles) {
  ClothDesc d;
  d.vertices = std::move(vertices), d.triangles = std::move(triangles);
  return d;
}

ClothDesc hung(const char* solver) {
  ClothDesc d = sheet(13, 13, 1, 1);
  d.solver = solver;
  d.stretch = 200;
  d.pin_names = {"top"};
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 3);
  return d;
}

}  // namespace

TEST_CASE("bad meshes are refused, and the place is named", "[cloth]") {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 0, 1), e(1, 0, 1), up(0, 1, 0);
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  CHECK_THAT(refusal(mesh({a, b, Vec3(0, nan, 1)}, {0, 1, 2})),
             Catch::Contains("vertices[3]: expected finite numbers"));
  CHECK_THAT(refusal(mesh({a, b, c}, {0, 1, 3})),
             Catch::Contains("triangles[1]: expected vertex numbers from 1 to 3, got 4"));
  CHECK_THAT(refusal(mesh({a, b, Vec3(2, 0, 0)}, {0, 1, 2})),
             Catch::Contains("triangles[1]: expected a triangle with an area"));
  CHECK_THAT(refusal(mesh({a, b, c}, {0, 1, 1})), Catch::Contains("without one"));
  CHECK_THAT(refusal(mesh({a, b, c, e, up}, {0, 1, 2, 1, 0, 3, 0, 1, 4})),
             Catch::Contains("the edge 1-2 belongs to more than two triangles (1 and 2, 3)"));
  CHECK_THAT(refusal(mesh({a, b, c, e},
                          {
                              0,
                              1,
                              2,
                              1,
                              2,
                              3,
                          })),
             Catch::Contains("the edge 2-3 is run the same way by triangles 1 and 2"));
  CHECK_THAT(refusal(mesh({a, b, c, e}, {0, 1, 2})), Catch::Contains("vertices[4]: belongs to no triangle"));
  CHECK_THAT(refusal(mesh({a, b, c}, {0, 1})), Catch::Contains("three vertex numbers each"));
  ClothDesc d = sheet(3, 3, 1, 1);
  d.area_density = 0;
  CHECK_THAT(refusal(d), Catch::Contains("area_density: expected a number above 0"));
  d = sheet(3, 3, 1, 1);
  d.stretch = nan;
  CHECK_THAT(refusal(d), Catch::Contains("stretch: expected a number above 0"));
  d = sheet(3, 3, 1, 1);
  d.pin_names = {"top_lft"};
  CHECK_THAT(refusal(d), Catch::Contains("did you mean 'top_left'?"));
  d = sheet(3, 3, 1, 1);
  d.solver = "xpdb";
  CHECK_THAT(refusal(d), Catch::Contains("unknown cloth solver 'xpdb'; known: xpbd, mass_spring"));
  d = sheet(3, 3, 1, 1);
  d.pins = {9};
  CHECK_THAT(refusal(d), Catch::Contains("pins: expected vertex numbers"));
  d = mesh({a, b, c}, {0, 1, 2});
  d.pin_names = {"top"};
  CHECK_THAT(refusal(d), Catch::Contains("only sheets have named sides"));
}

TEST_CASE("masses follow the area; names pin the sides they say", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(5, 4, 2, Real(1.5));
  d.area_density = Real(0.3);
  d.pin_names = {"left", "top_right"};
  const ObjectId id = cloth.add_cloth(d);
  double mass = 0;
  for (std::size_t i = 0; i < 20; ++i) mass += static_cast<double>(cloth.point_mass(id, i));
  CHECK(mass == Approx(0.3 * 3));
  for (std::size_t i = 0; i < 20; ++i) CHECK(cloth.pinned(id, i) == (i % 5 == 0 || i == 4));
  CHECK(cloth.point(id, 0)[0] == Approx(-1));
  CHECK(cloth.point(id, 0)[2] == Approx(-0.75));
  CHECK(cloth.triangle_count(id) == 24);
  CHECK(cloth.edge_count(id) == 4 * 4 + 3 * 5 + 12);
}

TEST_CASE("a free cloth keeps momentum and angular momentum", "[cloth]") {
  const char* solver = any_solver();
  CAPTURE(solver);
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(9, 9, 1, 1);
  d.solver = solver;
  d.stretch = 300;
  d.max_substeps = 64;
  if (std::string(solver) == "xpbd") d.substeps = 16;  // rotation is lost in proportion to the solver substep
  const ObjectId id = cloth.add_cloth(d);
  for (std::size_t i = 0; i < 81; ++i) {
    const Vec3 x = cloth.point(id, i);
    cloth.set_velocity(
        id, i,
        Vec3(Real(0.4), Real(0.3), 0) + cross(Vec3(1, 2, Real(0.5)), x) + Real(0.3) * Vec3(0, std::sin(7 * x[0]), 0));
  }
  const Momentum before = w.momentum();
  for (int k = 0; k < 240; ++k) w.step();
  const Momentum after = w.momentum();
  const double p = std::hypot(before.linear[0], before.linear[1]),
               l = std::hypot(before.angular[0], before.angular[1], before.angular[2]);
  for (int k = 0; k < 3; ++k) {
    CHECK(after.linear[k] == Approx(before.linear[k]).margin(p * 5000 * static_cast<double>(kEpsilon)));
    CHECK(after.angular[k] == Approx(before.angular[k]).margin(0.02 * l));
  }
}

TEST_CASE("a cloth tears where it is stretched most; the mesh stays one, and momentum is kept", "[cloth]") {
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.options.set("air_density", 0.0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(9, 9, 1, 1);
  d.stretch = 100;
  d.tear_strain = Real(0.2);  // halves that part at 6 m/s strain the middle by 6/sqrt(stretch/area_density) = 0.27
  const ObjectId id = cloth.add_cloth(d);
  for (std::size_t i = 0; i < 81; ++i)
    cloth.set_velocity(id, i, Vec3(cloth.point(id, i)[0] > 0 ? Real(6) : Real(-6), 0, 0));
  const Momentum before = w.momentum();
  std::size_t tears = 0;
  double mass = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != kTear) continue;
      ++tears;
      CHECK(e.a == id);
      CHECK(e.force > 0);
    }
  }
  const std::size_t points = cloth.vertex_count(id);
  CHECK(tears >= 9);
  CHECK(points >= 81 + tears);
  CHECK(cloth.triangle_count(id) == 128);
  std::vector<std::uint32_t> triangles;
  std::vector<Vec3> rest;
  cloth.triangles(id, triangles);
  for (std::size_t i = 0; i < points; ++i) {
    rest.push_back(cloth.vertices().rest[i]);
    mass += static_cast<double>(cloth.point_mass(id, i));
  }
  CHECK_NOTHROW(check_mesh(rest, triangles));
  CHECK(mass == Approx(0.2));
  CHECK(std::fabs(w.momentum().linear[0] - before.linear[0]) < 1e-4);
  CHECK(w.is_finite());
  // two parts fly apart
  CHECK(cloth.point(id, 0)[0] < Real(-1));
  CHECK(cloth.point(id, 8)[0] > 1);
}

TEST_CASE("a cloth at rest falls asleep, and wakes when a pin goes, or gravity changes after a restore", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = hung("xpbd");
  d.damping = Real(0.05);
  const ObjectId id = cloth.add_cloth(d);
  int slept = 0, woke = 0;
  const auto run = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      w.step();
      if (k % 4 == 0 && !cloth.asleep(id) && slept == 0 && k < 600)
        for (std::size_t i = 0; i < 169; ++i) cloth.set_velocity(id, i, Real(0.7) * cloth.velocity(id, i));
      for (const Event& e : w.events().list()) slept += e.kind == EventKind::sleep, woke += e.kind == EventKind::wake;
    }
  };
  run(1500);
  CHECK(slept == 1);
  CHECK(cloth.asleep(id));
  const std::uint64_t hash = w.hash();
  const Vec3 x = cloth.point(id, 168);
  run(10);
  CHECK(cloth.point(id, 168) == x);
  CHECK(w.hash() != hash);  // steps count
  const std::string image = w.snapshot();
  w.restore(image);
  w.set_gravity(Vec3(1, -9, 0));
  w.step();
  CHECK(!cloth.asleep(id));
  w.restore(image);
  REQUIRE(cloth.asleep(id));
  cloth.unpin(id, 0);
  run(30);
  CHECK(woke == 1);
  CHECK(length(cloth.point(id, 0) - cloth.vertices().rest[0]) > Real(0.01));
}

TEST_CASE("restore then run equals run, bit for bit", "[cloth]") {
  const char* solver = any_solver();
  CAPTURE(solver);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = hung(solver);
  d.tear_strain = Real(0.5);
  cloth.add_cloth(d);
  ClothDesc other = sheet(7, 7, Real(0.6), Real(0.6));
  other.pose.position = Vec3(0, 1, 0);
  const ObjectId second = cloth.add_cloth(other);
  for (int k = 0; k < 20; ++k) w.step();
  const std::string image = w.snapshot();
  for (int k = 0; k < 30; ++k) w.step();
  const std::uint64_t hash = w.hash();
  cloth.destroy_cloth(second, "");
  w.step();
  w.restore(image);
  for (int k = 0; k < 30; ++k) w.step();
  CHECK(w.hash() == hash);
}

TEST_CASE("a sheet large enough for all loops in parts touches itself alike on any number of threads",
          "[cloth][threads]") {
  std::uint64_t hash = 0;
  for (const int threads : {1, 4}) {
    WorldDesc wd;
    wd.threads = threads;
    World w(wd, kClothOnly);
    Cloth& cloth = w.need<Cloth>();
    ClothDesc d = sheet(104, 104, 1, 1);  // 10,816 points
    d.substeps = 2;
    d.pin_names = {"top_left"};
    const ObjectId id = cloth.add_cloth(d);
    for (std::size_t i = 0; i < cloth.vertex_count(id); ++i)  // a wave that folds
      cloth.set_velocity(id, i, Vec3(0, std::sin(40 * cloth.point(id, i)[0]), 0));
    for (int k = 0; k < 2; ++k) w.step();
    CHECK(w.is_finite());
    if (threads == 1) hash = w.hash();
    CHECK(w.hash() == hash);
  }
}

TEST_CASE("threads and kernels change nothing, and stepping allocates nothing", "[cloth][threads]") {
  const char* solver = any_solver();
  CAPTURE(solver);
  std::uint64_t hash = 0;
  for (const int variant : {1, 2, 4, 0}) {
    WorldDesc wd;
    wd.threads = variant ? variant : 1;
    wd.sleeping = false;
    World w(wd, kClothOnly);
    Cloth& cloth = w.need<Cloth>();
    ClothDesc d = sheet(60, 60, 1, 1);  // enough for several jobs
    d.solver = solver;
    d.stretch = 1;
    d.substeps = std::string(solver) == "mass_spring" ? 16 : 2;  // Heun bears no fewer
    d.self_collision = false;
    d.pin_names = {"top_left"};
    const bool wide = std::string(solver) == "xpbd" || std::string(solver) == "vbd";
    if (variant == 0 && wide) d.solver_options.set("kernels", std::string("plain"));
    cloth.add_cloth(d);
    const int steps = kAsserts ? 1 : 3;  // with asserts a step takes seconds
    for (int k = 0; k < steps; ++k) w.step();
    const std::uint64_t allocations = w.allocations();
    for (int k = 0; k < steps + 1; ++k) w.step();
    CHECK(w.allocations() == allocations);
    CHECK(w.is_finite());
    if (variant == 1) hash = w.hash();
    CHECK(w.hash() == hash);
  }
}

TEST_CASE("extremes: never a number that is not finite, never silence", "[cloth]") {
  const double stretch = GENERATE(1.0, 1e3, 1e6), bend = GENERATE(0.0, 1e-3, 1.0);
  run_extreme({stretch, bend, GENERATE(Extreme::as_made, Extreme::one_far, Extreme::random)});
}

TEST_CASE("extremes that collide with themselves", "[cloth]") {
  const double bend = GENERATE(0.0, 1.0);
  run_extreme({1, bend, GENERATE(Extreme::as_made, Extreme::one_far, Extreme::random), true, "xpbd", 9, 90});
}

TEST_CASE("a stiff tangle that collides with itself", "[cloth][late]") {
  run_extreme({1e6, 0, Extreme::random, true, "xpbd", 9, 90});
}

TEST_CASE("other stiff extremes that collide with themselves", "[cloth][late]") {
  const double bend = GENERATE(0.0, 1.0);
  run_extreme({1e6, bend, GENERATE(Extreme::as_made, Extreme::one_far, Extreme::random), true, "xpbd", 9, 90});
}
