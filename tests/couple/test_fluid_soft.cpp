// Fluid and soft bodies: what one side gets the other gives, nothing gets into a body, and bodies float at their
// density.
#include <cmath>

#include "couple/fluid_parts.h"
#include "couple/fluid_soft.h"
#include "support/catch.h"

using namespace feder;

namespace {

Catalog soaked_catalog() {
  static const std::vector<const SystemDescriptor*> list = [] {
    const Catalog mixed = mixed_catalog();
    std::vector<const SystemDescriptor*> all(mixed.begin(), mixed.end());
    all.push_back(&Soft::descriptor()), all.push_back(&FluidSoft::descriptor());
    return all;
  }();
  return {list.data(), list.size()};
}

SoftDesc cube(Real size, std::uint32_t resolution, const Vec3& middle) {
  SoftDesc d;
  d.shape = make_box(size, size, size);
  d.resolution = resolution;
  d.pose.position = middle;
  return d;
}

WorldDesc space() {
  WorldDesc d;
  d.gravity = Vec3(0, 0, 0);
  d.options.set("air_density", 0.0);
  return d;
}

Vec3 momentum_of(const Soft& soft, ObjectId id) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < soft.point_count(id); ++i) sum += soft.point_mass(id, i) * soft.velocity(id, i);
  return sum;
}

Vec3 mean_of(const Soft& soft, ObjectId id) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < soft.point_count(id); ++i) sum += soft.point(id, i);
  return sum / static_cast<Real>(soft.point_count(id));
}

// Particles inside tetrahedra: all against all.
int count_inside(const Fluid& fluid, ObjectId water, const Soft& soft, ObjectId block) {
  std::vector<Vec3> x, p;
  fluid.positions(water, x), soft.positions(block, p);
  int inside = 0;
  for (const Vec3& q : x)
    for (std::size_t k = 0; k < soft.tetrahedron_count(block); ++k) {
      const auto t = soft.tetrahedron(block, k);
      const auto side = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
        const Vec3 n = cross(Vec3(p[t[b]] - p[t[a]]), Vec3(p[t[c]] - p[t[a]]));
        return dot(n, Vec3(q - p[t[a]])) * dot(n, Vec3(p[t[d]] - p[t[a]])) > 0;
      };
      if (side(0, 1, 2, 3) && side(0, 1, 3, 2) && side(0, 2, 3, 1) && side(1, 2, 3, 0)) {
        ++inside;
        break;
      }
    }
  return inside;
}

void add_box_wall(Rigid& rigid, const Vec3& size, const Vec3& at) {
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = make_box(size[0], size[1], size[2]);
  b.position = at;
  rigid.add_body(b);
}

// A floor at height 0 and four walls round a square.
void add_tank(World& w, Real wide) {
  Rigid& rigid = w.need<Rigid>();
  add_box_wall(rigid, Vec3(wide + 1, 1, wide + 1), Vec3(0, Real(-0.5), 0));
  for (const Real side : {Real(-1), Real(1)}) {
    add_box_wall(rigid, Vec3(Real(0.2), 2, wide + 1), Vec3(side * (wide / 2 + Real(0.1)), 1, 0));
    add_box_wall(rigid, Vec3(wide + 1, 2, Real(0.2)), Vec3(0, 1, side * (wide / 2 + Real(0.1))));
  }
}

// Particles on a lattice in the tank up to a height, but for those in the middle above `low`.
std::vector<Vec3> water_round(Real wide, Real high, Real gap, Real low, Real d) {
  std::vector<Vec3> x;
  for (Real v = d / 2; v < high; v += d)
    for (Real u = d / 2 - wide / 2; u < wide / 2; u += d)
      for (Real s = d / 2 - wide / 2; s < wide / 2; s += d)
        if (v < low || std::fmax(std::fabs(u), std::fabs(s)) > gap / 2) x.push_back(Vec3(u, v, s));
  return x;
}

// A block that floats in a tank.
struct Float {
  Float(const std::string& solver, Real density, const WorldDesc& desc = {})
      : w(desc, soaked_catalog()), soft(w.need<Soft>()), fluid(w.need<Fluid>()) {
    const Real d = FluidDesc().spacing, low = std::round((kHigh - Real(0.4) * density / 1000) / d - 1) * d;
    add_tank(w, Real(0.9));
    FluidDesc f;
    f.solver = solver;
    water = fluid.add_fluid(f);
    fluid.fill(water, water_round(Real(0.9), kHigh, Real(0.4), low, d), Vec3::Zero());
    SoftDesc s = cube(Real(0.4), 6, Vec3(0, low + Real(0.205), 0));
    s.density = density;
    block = soft.add_soft(s);
  }
  // Depth of the block's bottom below the level of the water beside it, from the block's middle.
  double depth() const {
    std::vector<Vec3> x;
    std::vector<Real> y;
    fluid.positions(water, x);
    for (const Vec3& q : x)
      if (std::fmax(std::fabs(q[0]), std::fabs(q[2])) > Real(0.25)) y.push_back(q[1]);
    std::sort(y.begin(), y.end());
    const Real level = y[y.size() * 97 / 100] + FluidDesc().spacing / 2;
    return static_cast<double>(level - (mean_of(soft, block)[1] - Real(0.2)));
  }
  static constexpr Real kHigh = Real(0.6);
  World w;
  Soft& soft;
  Fluid& fluid;
  ObjectId water, block;
};

}  // namespace

TEST_CASE("a blob hits a free soft block: momentum and angular momentum are kept", "[couple][fluid][soft]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
  World w(space(), soaked_catalog());
  Soft& soft = w.need<Soft>();
  const ObjectId block = soft.add_soft(cube(Real(0.4), 4, Vec3(0, Real(-0.25), 0)));
  check_blow(w, solver, "fluid_soft.impulse_mismatch", 0.3, [&] { return momentum_of(soft, block); });
}

TEST_CASE("particles between a sheet and a soft block push both", "[couple][fluid][soft][cloth]") {
  World w(space(), soaked_catalog());
  Soft& soft = w.need<Soft>();
  Cloth& cloth = w.need<Cloth>();
  Fluid& fluid = w.need<Fluid>();
  SoftDesc s = cube(Real(0.6), 5, Vec3(0, Real(-0.35), 0));
  const ObjectId block = soft.add_soft(s);
  ClothDesc c = square(9, Real(0.6), false);
  c.area_density = 2;
  c.pose.position = Vec3(0, Real(0.1), 0);
  const ObjectId sheet = cloth.add_cloth(c);
  for (std::size_t i = 0; i < cloth.vertex_count(sheet); ++i) cloth.set_velocity(sheet, i, Vec3(0, -1, 0));
  const ObjectId layer = fluid.add_fluid(FluidDesc{});
  fluid.fill(layer, feder::block(9, 1, 9, Real(0.05), Vec3(0, Real(-0.01), 0)), Vec3::Zero());
  const Vec3 p = vec(w.momentum().linear);
  double given = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    given = std::fmax(given, -static_cast<double>(momentum_of(soft, block)[1]));
    CHECK(count_inside(fluid, layer, soft, block) == 0);
  }
  CHECK(given > 0.1 * static_cast<double>(length(p)));
  CHECK(length(Vec3(vec(w.momentum().linear) - p)) < Real(1e-5) * length(p));
  CHECK(w.is_finite());
}

TEST_CASE("no particle gets into a soft block", "[couple][fluid][soft]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
  const double speed = GENERATE(1.0, 10.0, 20.0);
  World w(WorldDesc{}, soaked_catalog());
  Soft& soft = w.need<Soft>();
  Fluid& fluid = w.need<Fluid>();
  add_tank(w, Real(0.8));
  const ObjectId block = soft.add_soft(cube(Real(0.4), 4, Vec3(Real(0.05), Real(0.21), 0)));
  FluidDesc f;
  f.solver = solver;
  const ObjectId water = fluid.add_fluid(f);
  // some lies round it already
  fluid.fill(water, water_round(Real(0.8), Real(0.1), Real(0.6), 0, f.spacing), Vec3::Zero());
  fluid.fill(water, feder::block(5, 6, 5, f.spacing, Vec3(Real(0.013), Real(0.7), Real(0.027))),
             Vec3(0, static_cast<Real>(-speed), 0));
  const std::size_t count = fluid.particle_count(water);
  int inside = 0;
  for (int k = 0; k < 90; ++k) {
    w.step();
    inside += count_inside(fluid, water, soft, block);
  }
  CAPTURE(solver, speed, inside, count, residual(w, "fluid_soft.guarded"), residual(w, "soft.max_strain"));
  CHECK(inside == 0);
  CHECK(fluid.particle_count(water) == count);
  CHECK(w.is_finite());
}

namespace {

void check_floating(const std::string& solver, Real density) {
  Float f(solver, density);
  double depth = 0, force = 0;
  for (int k = 0; k < 240; ++k) {
    f.w.step();
    if (k >= 120) depth += f.depth() / 120, force += residual(f.w, "fluid_soft.force_n") / 120;
  }
  const double weight = static_cast<double>(density) * 0.064 * 9.81;
  CAPTURE(solver, density, depth, force, weight);
  // half a cell is 0.033 m, half a spacing 0.025 m
  CHECK(std::fabs(depth - 0.4 * static_cast<double>(density) / 1000) < 0.025);
  CHECK(std::fabs(force + weight) < 0.03 * weight);
  CHECK(count_inside(f.fluid, f.water, f.soft, f.block) == 0);
}

}  // namespace

TEST_CASE("a soft block floats at its density", "[couple][fluid][soft][heavy]") {
  using Row = std::pair<std::string, Real>;
  const auto [solver, density] = GENERATE(Row{"dfsph", 900}, Row{"pbf", 300});
  check_floating(solver, density);
}

TEST_CASE("a soft block floats at its density: the other pairs of solver and density", "[couple][fluid][soft][late]") {
  using Row = std::pair<std::string, Real>;
  const auto [solver, density] = GENERATE(Row{"dfsph", 300}, Row{"dfsph", 500}, Row{"pbf", 500}, Row{"pbf", 900},
                                          Row{"wcsph", 300}, Row{"wcsph", 500}, Row{"wcsph", 900});
  check_floating(solver, density);
}

TEST_CASE("fluid wakes a soft body, and keeps it awake while it presses on it", "[couple][fluid][soft]") {
  World w(WorldDesc{}, soaked_catalog());
  Soft& soft = w.need<Soft>();
  Fluid& fluid = w.need<Fluid>();
  add_tank(w, Real(0.6));
  const ObjectId block = soft.add_soft(cube(Real(0.3), 3, Vec3(0, Real(0.155), 0)));
  const ObjectId water = fluid.add_fluid(FluidDesc{});
  int steps = 0;
  while (!soft.asleep(block) && steps < 600) w.step(), ++steps;
  REQUIRE(soft.asleep(block));
  // a drop falls from 0.5 m above it: it wakes when that arrives, not before
  fluid.fill(water, feder::block(2, 2, 2, Real(0.05), Vec3(0, Real(0.8), 0)), Vec3::Zero());
  int woke = -1;
  for (int k = 0; k < 60 && woke < 0; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::wake && e.a == block) {
        woke = k;
        CHECK(e.cause == kFluidCause);
        CHECK(e.b == water);
      }
  }
  CHECK(woke > 12);
  CHECK(woke < 24);
  // in a pool it stays awake, when that is gone it sleeps again
  fluid.fill(water, water_round(Real(0.6), Real(0.2), Real(0.4), 0, Real(0.05)), Vec3::Zero());
  for (int k = 0; k < 240; ++k) {
    w.step();
    CHECK(!soft.asleep(block));
  }
  fluid.destroy_fluid(water, "");
  for (int k = 0; k < 300; ++k) w.step();
  CHECK(soft.asleep(block));
}

TEST_CASE("fluid and soft bodies: contacts begin and end in pairs, one per fluid and body", "[couple][fluid][soft]") {
  const bool destroyed = GENERATE(false, true);
  World w(space(), soaked_catalog());
  w.events().set_wanted(EventKind::hit, true);
  Soft& soft = w.need<Soft>();
  Fluid& fluid = w.need<Fluid>();
  const ObjectId block = soft.add_soft(cube(Real(0.4), 4, Vec3(0, Real(-0.25), 0)));
  const ObjectId id = fluid.add_fluid(FluidDesc{});
  fluid.fill(id, feder::block(3, 3, 3, Real(0.05), Vec3(0, Real(0.3), 0)), Vec3(0, -3, 0));
  int begins = 0, ends = 0, hits = 0;
  for (int k = 0; k < 120; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end && e.kind != EventKind::hit) continue;
      const bool in_order = e.a == block && e.b == id;
      CHECK((in_order || (e.a == id && e.b == block)));
      if (e.kind == EventKind::hit) {
        if (++hits == 1) CHECK(e.speed == Approx(3).epsilon(0.1));
        continue;
      }
      ++(e.kind == EventKind::contact_begin ? begins : ends);
      CHECK((begins == ends || begins == ends + 1));
      if (e.kind == EventKind::contact_begin) CHECK((in_order ? e.normal[1] : -e.normal[1]) > Real(0.5));
    }
    if (destroyed && begins > 0 && soft.soft_count() > 0) soft.destroy_soft(block, "");
  }
  CHECK(begins >= 1);
  CHECK(hits >= 1);
  CHECK(begins == ends);  // it left it, or the block is gone
}

TEST_CASE("a floating block: same hash for any number of threads, and after a snapshot",
          "[couple][fluid][soft][threads]") {
  std::uint64_t first = 0;
  for (const int threads : {1, 2, 4}) {
    WorldDesc desc;
    desc.threads = threads;
    Float f("dfsph", 500, desc);
    std::string image;
    for (int k = 0; k < 24; ++k) {
      f.w.step();
      if (k == 11) image = f.w.snapshot();
    }
    const std::uint64_t hash = f.w.hash();
    CHECK(residual(f.w, "fluid_soft.force_n") < -50);
    if (first == 0) first = hash;
    CHECK(hash == first);
    f.w.restore(image);
    for (int k = 12; k < 24; ++k) f.w.step();
    CHECK(f.w.hash() == first);
  }
}

TEST_CASE("particles that are filled into a soft block are moved out, with a warning", "[couple][fluid][soft]") {
  const std::string solver = GENERATE(std::string("pbf"), std::string("wcsph"), std::string("dfsph"));
  World w(space(), soaked_catalog());
  Soft& soft = w.need<Soft>();
  Fluid& fluid = w.need<Fluid>();
  const ObjectId block = soft.add_soft(cube(Real(0.4), 4, Vec3(0, 0, 0)));
  FluidDesc f;
  f.solver = solver;
  const ObjectId water = fluid.add_fluid(f);
  // half of them above it
  fluid.fill(water, feder::block(3, 4, 3, f.spacing, Vec3(Real(0.01), Real(0.2), Real(0.02))), Vec3::Zero());
  CHECK(count_inside(fluid, water, soft, block) == 18);
  int warnings = 0;
  for (int k = 0; k < 60; ++k) {
    w.step();
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "fluid_inside") ++warnings;
    CHECK(count_inside(fluid, water, soft, block) == 0);
  }
  CHECK(warnings == 1);
  CHECK(fluid.particle_count(water) == 36);
  CHECK(length(vec(w.momentum().linear)) < Real(1e-3));
  CHECK(w.is_finite());
}
