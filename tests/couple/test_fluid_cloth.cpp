// Fluid and cloth: what one side gets the other gives, nothing passes a sheet, a sheet carries a pool by its edges.
#include <cmath>

#include "couple/fluid_parts.h"
#include "feder/error.h"
#include "support/catch.h"

using namespace feder;

TEST_CASE("a blob hits a free sheet: momentum and angular momentum are kept", "[couple][fluid][cloth]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.dt = 1.0 / 120;
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  World w(wd, mixed_catalog());
  Cloth& cloth = w.need<Cloth>();
  ClothDesc sheet = square(13, 1, false);
  sheet.area_density = 1;
  sheet.substeps = 8;
  const ObjectId id = cloth.add_cloth(sheet);
  check_blow(w, solver, "fluid_cloth.impulse_mismatch", 0.05, [&] {
    Vec3 u = Vec3::Zero();
    for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) u += cloth.point_mass(id, i) * cloth.velocity(id, i);
    return u;
  });
}

TEST_CASE("a drop that slides on a sheet is slowed by friction", "[couple][fluid][cloth]") {
  World w(WorldDesc{}, mixed_catalog());
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(square(11, 2, true));
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) cloth.pin(id, i);
  check_slide(w, Real(0.005));
}

TEST_CASE("no particle passes a pinned sheet", "[couple][fluid][cloth]") {
  const double speed = GENERATE(1.0, 20.0, 80.0);
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
  WorldDesc wd;
  World w(wd, mixed_catalog());
  Fluid& fluid = w.need<Fluid>();
  ClothDesc sheet = square(15, 2, true);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId cid = cloth.add_cloth(sheet);
  FluidDesc d;
  d.solver = solver;
  const ObjectId id = fluid.add_fluid(d);
  fluid.fill(id, block(5, 5, 5, d.spacing, Vec3(Real(0.013), Real(0.3), Real(0.027))),
             Vec3(0, static_cast<Real>(-speed), 0));
  std::vector<Vec3> x;
  int below = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    fluid.positions(id, x);
  }
  // what passed is far below by now; splashes over the edges are beside the sheet
  Real lowest = 0;
  for (std::size_t i = 0; i < cloth.vertex_count(cid); ++i) lowest = std::min(lowest, cloth.point(cid, i)[1]);
  for (const Vec3& q : x) below += q[1] < lowest - Real(0.1) && std::fabs(q[0]) < 1 && std::fabs(q[2]) < 1;
  CAPTURE(solver, speed, below, x.size(), residual(w, "fluid_cloth.guarded"), residual(w, "cloth.max_strain"));
  CHECK(below == 0);
  CHECK(x.size() == 125);
  CHECK(w.is_finite());
}

TEST_CASE("a sheet in a free frame holds a pool: the frame feels the weight of water and cloth",
          "[couple][fluid][cloth][heavy]") {
  World w(WorldDesc{}, mixed_catalog());
  Rigid& rigid = w.need<Rigid>();
  Fluid& fluid = w.need<Fluid>();
  Cloth& cloth = w.need<Cloth>();
  // weightless and heavy: its velocity is the scale
  constexpr Real kSize = 1, kFrame = 20000, kHigh = 1;  // drops leap from a taut sheet
  std::vector<CompoundPart> parts;
  for (int k = 0; k < 4; ++k) {
    const bool along = k < 2;
    const Real far = (k % 2 ? Real(0.5) : Real(-0.5)) * (kSize + Real(0.1));
    parts.push_back({make_box(along ? kSize + Real(0.2) : Real(0.1), kHigh, along ? Real(0.1) : kSize + Real(0.2)),
                     Pose{along ? Vec3(0, kHigh / 2, far) : Vec3(far, kHigh / 2, 0), Quat{}}});
  }
  BodyDesc b;
  b.shape = make_compound(parts);
  b.mass = kFrame;
  b.gravity_scale = 0;
  const ObjectId frame = rigid.add_body(b);
  ClothDesc sheet = square(17, kSize, false);
  sheet.area_density = 1;
  sheet.stretch = 20000;
  const ObjectId id = cloth.add_cloth(sheet);
  for (std::size_t i = 0; i < 17 * 17; ++i) {
    const Vec3 x = cloth.point(id, i);
    if (std::fabs(x[0]) > Real(0.49) || std::fabs(x[2]) > Real(0.49)) cloth.attach(id, i, frame, x);
  }
  FluidDesc d;
  d.spacing = Real(0.08);
  const ObjectId pool = fluid.add_fluid(d);
  fluid.fill(pool, block(12, 2, 12, d.spacing, Vec3(0, Real(0.14), 0)), Vec3::Zero());
  const double water = 12 * 12 * 2 * static_cast<double>(fluid.particle_mass(pool));
  const double weight = (water + 1) * 9.81;
  for (int k = 0; k < 240; ++k) w.step();
  const Real before = rigid.bodies().velocity[rigid.index(frame)][1];
  double force = 0;
  for (int k = 0; k < 240; ++k) {
    w.step();
    force += residual(w, "fluid_cloth.force_n") / 240;
  }
  const Real after = rigid.bodies().velocity[rigid.index(frame)][1];
  const double reaction = static_cast<double>(kFrame * (before - after)) / 4;
  std::vector<Vec3> x;
  fluid.positions(pool, x);
  double lowest = 1;
  const double fallen = static_cast<double>(rigid.pose(frame).position[1]);
  for (const Vec3& q : x) lowest = std::fmin(lowest, static_cast<double>(q[1]) - fallen);
  CAPTURE(water, weight, force, reaction, lowest, fallen, residual(w, "cloth.max_strain"),
          residual(w, "fluid.density_error_max"));
  CHECK(std::fabs(reaction - weight) < 0.03 * weight);
  CHECK(force > 0.9 * water * 9.81);
  CHECK(lowest > -0.4);
  CHECK(static_cast<double>(cloth.point(id, 17 * 8 + 8)[1]) - fallen < -0.02);  // it sags
  CHECK(w.is_finite());
}

TEST_CASE("fluid that comes wakes a sleeping sheet, and says so", "[couple][fluid][cloth]") {
  World w(WorldDesc{}, mixed_catalog());
  Cloth& cloth = w.need<Cloth>();
  Fluid& fluid = w.need<Fluid>();
  const ObjectId sheet = cloth.add_cloth(square(7, Real(0.6), true));
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(2, 2, 2, Real(0.05), Vec3(0, 2, 0)), Vec3::Zero());
  w.step();
  cloth.sleep(sheet);
  REQUIRE(cloth.asleep(sheet));
  int woken = 0, step = 0;
  for (; step < 90 && !woken; ++step) {
    w.step();
    for (const Event& e : w.events().list())
      woken += e.kind == EventKind::wake && e.a == sheet && e.cause == kFluidCause && e.b == id;
  }
  CAPTURE(step);
  CHECK(woken == 1);
  CHECK(step > 30);  // it falls for 0.63 s
  CHECK(step < 42);
}

TEST_CASE("fluid and cloth: contacts begin and end in pairs, one per fluid and cloth", "[couple][fluid][cloth]") {
  const bool destroyed = GENERATE(false, true);
  WorldDesc wd;
  wd.gravity = Vec3(0, 0, 0);
  wd.sleeping = false;
  World w(wd, mixed_catalog());
  Cloth& cloth = w.need<Cloth>();
  Fluid& fluid = w.need<Fluid>();
  const ObjectId sheet = cloth.add_cloth(square(9, 1, true));
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, block(3, 3, 3, Real(0.05), Vec3(0, Real(0.3), 0)), Vec3(0, -3, 0));
  int begins = 0, ends = 0;
  std::uint32_t most = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end) continue;
      CHECK(e.a == sheet);
      CHECK(e.b == id);
      const bool begin = e.kind == EventKind::contact_begin;
      ++(begin ? begins : ends);
      CHECK((begins == ends || begins == ends + 1));
      CHECK(begin == (e.index > 0));
      most = std::max(most, e.index);
      CHECK((!begin || e.normal[1] > Real(0.5)));
    }
    if (destroyed && begins > 0 && cloth.cloth_count() > 0) cloth.destroy_cloth(sheet, "");
  }
  CAPTURE(destroyed, begins, ends, most);
  CHECK(begins >= 1);
  CHECK(begins == ends);  // it bounced off, or the sheet is gone
  CHECK(most <= 27);
}

TEST_CASE("fluid on cloth and on nets: the same for any number of threads; on nets at rest steps allocate nothing",
          "[couple][fluid][cloth][threads]") {
  const bool net = GENERATE(false, true);
  std::uint64_t hash = 0;
  for (const int threads : {1, 2, 4}) {
    WorldDesc wd;
    wd.threads = threads;
    wd.sleeping = false;
    World w(wd, mixed_catalog());
    Fluid& fluid = w.need<Fluid>();
    if (net) {
      Springs& springs = w.need<Springs>();
      const ObjectId mesh = springs.add_net(mat(11, 1, 10, 4000));
      for (std::size_t i = 0; i < springs.point_count(mesh); ++i) {
        const Vec3 x = springs.point(mesh, i);
        if (std::fabs(x[0]) > Real(0.49) || std::fabs(x[2]) > Real(0.49)) springs.pin(mesh, i);
      }
    } else {
      w.need<Cloth>().add_cloth(square(11, 1, true));
    }
    const ObjectId id = fluid.add_fluid(FluidDesc{});
    fluid.fill(id, block(6, 4, 6, Real(0.05), Vec3(0, Real(0.15), 0)), Vec3::Zero());
    for (int k = 0; k < (net ? 150 : 300); ++k) w.step();  // it has come to lie there
    const std::uint64_t allocations = w.allocations();
    for (int k = 0; k < 20; ++k) w.step();
    const std::uint64_t end = w.hash();
    CAPTURE(net, threads);
    CHECK(residual(w, net ? "fluid_springs.impulse_ns" : "fluid_cloth.force_n") > 0);
    if (net) CHECK(w.allocations() == allocations);  // on cloth the number of contacts still grows, slowly
    if (threads == 1) hash = end;
    CHECK(end == hash);
  }
}

TEST_CASE("water that is filled after the sheet it knew is gone has room for all it keeps", "[couple][fluid][cloth]") {
  World w(WorldDesc{}, mixed_catalog());
  Fluid& fluid = w.need<Fluid>();
  Cloth& cloth = w.need<Cloth>();
  FluidDesc d;
  d.spacing = Real(0.1), d.max_particles = 5000;
  const ObjectId pool = fluid.add_fluid(d), sheet = cloth.add_cloth(square(5, 1, true));
  fluid.fill(pool, block(2, 2, 2, d.spacing, Vec3(0, Real(0.3), 0)), Vec3::Zero());
  w.step();
  cloth.destroy_cloth(sheet, "test");
  fluid.fill(pool, block(12, 12, 12, d.spacing, Vec3(2, 1, 0)), Vec3::Zero());
  for (int k = 0; k < 5; ++k) w.step();
  CHECK(w.is_finite());
  // another sheet finds them all
  cloth.add_cloth(square(5, 1, true));
  fluid.fill(pool, block(10, 10, 10, d.spacing, Vec3(4, 1, 0)), Vec3::Zero());
  for (int k = 0; k < 5; ++k) w.step();
  CHECK(w.is_finite());
  CHECK(fluid.particle_count(pool) == 8 + 1728 + 1000);
}
