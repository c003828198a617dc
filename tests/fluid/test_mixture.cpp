// Fluids that touch (fluid/mixture.h): the heavier one ends below, from any start, with the pressure of the weight
// above it; nothing of the momentum is lost between them; and they cost nothing where they do not meet.
#include <cmath>

#include "base/rng.h"
#include "fluid/any_solver.h"
#include "fluid/tank.h"

using namespace feder;

namespace {

constexpr Real kMixSpacing = Real(0.05);
constexpr int kMixAcross = 20, kMixLayers = 10;  // of each fluid

// Of the particles, m.
double mean_height(World& w, ObjectId id) {
  double sum = 0;
  const std::vector<Vec3> x = places(w, id);
  for (const Vec3& p : x) sum += static_cast<double>(p[1]);
  return sum / static_cast<double>(x.size());
}

// Two fluids in a tank in the plane: one over the other, or in squares of five spacings at random. The light one's
// spacing is `finer` times as small.
struct Layers {
  Layers(const std::string& solver, double ratio, const char* start, int threads = 1, bool sleeping = false,
         double finer = 1)
      : w(world(threads, sleeping), fluid_catalog()) {
    const Real width = kMixAcross * kMixSpacing, depth = kMixLayers * kMixSpacing;
    add_tank(w, vec3(width, 0, 0));
    FluidDesc d;
    d.solver = solver, d.spacing = static_cast<Real>(static_cast<double>(kMixSpacing) / finer);
    Fluid& f = w.need<Fluid>();
    light = f.add_fluid(d);
    d.density *= static_cast<Real>(ratio), d.spacing = kMixSpacing;
    heavy = f.add_fluid(d);
    const auto put = [&](ObjectId id, Real x, Real y, Real wide, Real high) {
      Pose pose;
      pose.position = vec3(x + wide / 2, y + high / 2, 0);
      f.fill(id, *make_box(wide, high, 1)->section(), pose, Vec3::Zero());
    };
    const std::string from = start;
    if (from != "blobs") {
      put(from == "heavy on top" ? light : heavy, 0, 0, width, depth);
      put(from == "heavy on top" ? heavy : light, 0, depth, width, depth);
      return;
    }
    Rng rng(7);
    std::vector<ObjectId> squares;
    for (int k = 0; k < kMixAcross * 2 * kMixLayers / 25; ++k) squares.push_back(k % 2 ? heavy : light);
    for (std::size_t k = squares.size() - 1; k > 0; --k)
      std::swap(squares[k], squares[static_cast<std::size_t>(rng.uniform(0, static_cast<Real>(k) + Real(0.999)))]);
    const Real e = 5 * kMixSpacing;
    for (std::size_t k = 0; k < squares.size(); ++k)
      put(squares[k], e * static_cast<Real>(k % (kMixAcross / 5)), e * static_cast<Real>(k / (kMixAcross / 5)), e, e);
  }
  // Of all its particles at rest, m.
  double depth(ObjectId id) {
    Fluid& f = w.need<Fluid>();
    return static_cast<double>(f.particle_count(id)) * std::pow(static_cast<double>(f.desc(id).spacing), 2) /
           (kMixAcross * static_cast<double>(kMixSpacing));
  }
  // By the mean height, over that at rest.
  double volume() { return (mean_height(w, light) + mean_height(w, heavy)) / (1.5 * depth(heavy) + depth(light) / 2); }
  static WorldDesc world(int threads, bool sleeping) {
    WorldDesc d = fluid_world(2, threads);
    d.sleeping = sleeping;
    return d;
  }
  // Share of the particles that are on the other one's side by more than a spacing.
  double misplaced() {
    const Real level = kMixLayers * kMixSpacing;
    std::size_t wrong = 0, all = 0;
    for (const Vec3& x : places(w, heavy)) wrong += x[1] > level + kMixSpacing, ++all;
    for (const Vec3& x : places(w, light)) wrong += x[1] < level - kMixSpacing, ++all;
    return static_cast<double>(wrong) / static_cast<double>(all);
  }
  // Mean over a row some spacings above the ground, by the weight of what is above it.
  double floor_pressure(double ratio, int spacings = 1) {
    const Real y = static_cast<Real>(spacings) * kMixSpacing;
    double sum = 0;
    for (int k = 1; k < kMixAcross; ++k)
      sum += w.query<Fluid>()->pressure_at(heavy, vec3(static_cast<Real>(k) * kMixSpacing, y, 0)) / (kMixAcross - 1);
    return sum / (9.81 * 1000 * (depth(light) + ratio * (depth(heavy) - static_cast<double>(y))));
  }
  World w;
  ObjectId light, heavy;
};

}  // namespace

TEST_CASE("what is heavier ends below, from any start", "[fluid][mixture]") {
  if (!kFull || kAsserts) return;
  const auto [ratio, start] = GENERATE(
      table<double, const char*>({{1.25, "heavy on top"}, {13.6, "blobs"}, {100.0, "heavy on top"}, {100.0, "blobs"}}));
  Layers l("dfsph", ratio, start);
  run(l.w, 20);
  CAPTURE(ratio, start, l.misplaced(), l.floor_pressure(ratio), l.volume());
  CHECK(l.misplaced() < 0.01);  // measured: 0
  CHECK(l.floor_pressure(ratio) == Approx(1).margin(0.05));
  // at a hundred, what presses the outermost heavy particles holds light ones half a spacing off
  CHECK(l.volume() == Approx(1).margin(ratio < 20 ? 0.01 : 0.03));
  double mean = 0, most = 0;
  l.w.query<Fluid>()->density_error(l.heavy, mean, most);
  CHECK(mean < 0.01);
  CHECK(l.w.is_finite());
}

TEST_CASE("fluids of unlike spacings are solved as one, and settle as like ones do", "[fluid][mixture][uneven]") {
  if (!kFull || kAsserts) return;
  const auto [ratio, start, finer] = GENERATE(table<double, const char*, double>(
      {{1.25, "heavy on top", 1.25}, {1.25, "heavy on top", 0.8}, {13.6, "blobs", 1.25}, {100.0, "blobs", 1.1}}));
  Layers l("dfsph", ratio, start, 1, false, finer);
  run(l.w, 20);
  CAPTURE(ratio, start, finer, l.misplaced(), l.floor_pressure(ratio, 2), l.volume());
  CHECK(l.misplaced() < 0.01);
  CHECK(l.floor_pressure(ratio, 2) == Approx(1).margin(0.05));
  CHECK(l.volume() == Approx(1).margin(ratio < 20 ? 0.01 : 0.03));
  CHECK(l.w.is_finite());
}

TEST_CASE("layers of unlike spacings rest with the pressure of their weight", "[fluid][mixture][uneven]") {
  if (!kFull) return;
  const std::string solver = any_fluid_solver();
  const double finer = GENERATE(1.25, 0.8);
  Layers l(solver, 1.5, "heavy below", 1, false, finer);
  run(l.w, 3);
  const Energy e = l.w.energy();
  const double mass = 2.5 * 1000 * static_cast<double>(kMixAcross * kMixLayers * kMixSpacing * kMixSpacing);
  const double speed = std::sqrt(2 * e.kinetic / mass), pressure = l.floor_pressure(1.5, 2), volume = l.volume();
  double mean = 0, most = 0;
  l.w.query<Fluid>()->density_error(l.light, mean, most);
  CAPTURE(solver, finer, speed, pressure, volume, mean, most);
  CHECK(l.misplaced() < 0.01);
  CHECK(volume == Approx(1).margin(solver == "dfsph" ? 0.01 : 0.04));
  CHECK(pressure == Approx(1).margin(0.1));  // of one row, at one moment; in the mean over the column: 0.97 to 1.01
  CHECK(speed < (solver == "dfsph" ? 0.03 : 0.1));
  CHECK(mean < 0.01);
}

// Films of a light fluid below a slightly heavier one stay where the lattice of pbf and wcsph holds them.
TEST_CASE("other solvers separate fluids that differ by more", "[fluid][mixture]") {
  if (!kFull || kAsserts) return;
  const std::string solver = GENERATE("pbf", "wcsph");
  const char* start = GENERATE("heavy on top", "blobs");
  Layers l(solver, 13.6, start);
  run(l.w, 10);
  CAPTURE(solver, start, l.misplaced(), l.floor_pressure(13.6));
  CHECK(l.misplaced() < 0.01);
  CHECK(l.w.is_finite());
}

TEST_CASE("layers at rest have the pressure of their weight, and sleep together", "[fluid][mixture]") {
  if (!kFull) return;
  const double ratio = 2;
  Layers l("dfsph", ratio, "heavy below", 1, true);
  run(l.w, 4);
  Fluid& f = l.w.need<Fluid>();
  CHECK(f.asleep(l.light));
  CHECK(f.asleep(l.heavy));
  CHECK(l.floor_pressure(ratio) == Approx(1).margin(0.03));
  CHECK(l.misplaced() == 0);
  // one does not sleep beside another that moves
  f.wake(l.heavy);
  std::vector<Vec3> v(f.particle_count(l.heavy), vec3(Real(0.5), 0, 0));
  f.set_velocities(l.heavy, v);
  run(l.w, 0.1);
  CHECK_FALSE(f.asleep(l.light));
}

TEST_CASE("a heavy fluid over a light one does not fall asleep", "[fluid][mixture]") {
  if (!kFull) return;
  Layers l("dfsph", 1.25, "heavy on top", 1, true);
  run(l.w, 3);
  CHECK_FALSE(l.w.need<Fluid>().asleep(l.light));
  CHECK_FALSE(l.w.need<Fluid>().asleep(l.heavy));
}

TEST_CASE("inside a drop in another fluid the tension between them is felt", "[fluid][mixture][color_field]") {
  if (!kFull || kAsserts) return;
  const double spacing = 0.006, radius = 0.1;
  World w(weightless(fluid_world(2)), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.spacing = static_cast<Real>(spacing), d.surface_tension = 1;
  const ObjectId drop = f.add_fluid(d), around = f.add_fluid(d);
  f.set_interface(drop, around, 1);
  std::vector<Vec3> inner, outer;
  for (int i = 0; i < 10000; ++i) {  // sunflower seeds (Vogel)
    const double r = spacing * std::sqrt((i + 0.5) / 3.14159265358979), turn = i * 2.39996322972865;
    if (r > 3 * radius) break;
    (r < radius ? inner : outer)
        .push_back(vec3(static_cast<Real>(1.2 * r * std::cos(turn)), static_cast<Real>(r / 1.2 * std::sin(turn)), 0));
  }
  f.fill(drop, inner, Vec3::Zero()), f.fill(around, outer, Vec3::Zero());
  run(w, 0.5);
  double jump = 0;
  const int steps = 60, places = 12;
  for (int k = 0; k < steps; ++k) {
    w.step();
    for (int n = 0; n < places; ++n) {
      const double turn = n * 2 * 3.14159265358979 / places;
      const auto at = [&](double r) {
        return vec3(static_cast<Real>(r * radius * std::cos(turn)), static_cast<Real>(r * radius * std::sin(turn)), 0);
      };
      jump += static_cast<double>(f.pressure_at(drop, at(0.4)) - f.pressure_at(around, at(2))) / (steps * places);
    }
  }
  CHECK(jump == Approx(1 / radius).epsilon(0.25));  // measured: 0.85
}

TEST_CASE("fluids that strike each other keep their momentum", "[fluid][mixture]") {
  const std::string solver = any_fluid_solver();
  const double ratio = GENERATE(1.25, 30.0);
  const Real finer = GENERATE(Real(1), Real(1.25));
  WorldDesc desc = weightless(fluid_world(3));
  World w(desc, fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.solver = solver, d.spacing = kMixSpacing, d.viscosity = 2, d.surface_tension = 1;
  const auto ball = [&](const Vec3& at, const Vec3& velocity, Real density, Real viscosity) {
    d.density = density, d.viscosity = viscosity;
    const ObjectId id = f.add_fluid(d);
    Pose pose;
    pose.position = at;
    f.fill(id, *make_sphere(3 * kMixSpacing), pose, velocity);
    return id;
  };
  const ObjectId a = ball(vec3(0, 0, 0), vec3(1, 0, 0), 1000, 2);
  d.spacing /= finer;
  const ObjectId b = ball(vec3(Real(0.35), Real(0.1), 0), vec3(-1, 0, 0), static_cast<Real>(1000 * ratio), 20);
  f.set_interface(a, b, Real(0.5));
  const Momentum before = w.momentum();
  const double mass = static_cast<double>(f.particle_mass(a)) * static_cast<double>(f.particle_count(a)) +
                      static_cast<double>(f.particle_mass(b)) * static_cast<double>(f.particle_count(b));
  run(w, 0.5 * kShare);
  const Momentum after = w.momentum();
  CAPTURE(solver, ratio, finer);
  double off = 0, turned = 0;
  for (int k = 0; k < 3; ++k) {
    off = std::max(off, std::fabs(after.linear[k] - before.linear[k]) / mass);
    turned = std::max(turned, std::fabs(after.angular[k] - before.angular[k]) / (mass * 0.2));
  }
  CAPTURE(off, turned);
  CHECK(off < 1e-5);
  CHECK(turned < 1e-3);
  CHECK(w.is_finite());
}

TEST_CASE("fluids that touch give the same on any number of threads, and after a restore",
          "[fluid][mixture][threads]") {
  const std::string solver = any_fluid_solver();
  const int threads = GENERATE(2, 4);
  const double finer = threads == 2 ? 1 : 1.2;
  CAPTURE(solver, threads);
  Layers one(solver, 4, "blobs", 1, false, finer), many(solver, 4, "blobs", threads, false, finer);
  for (int k = 0; k < 20; ++k) one.w.step(), many.w.step();
  CHECK(one.w.hash() == many.w.hash());
  const std::string image = one.w.snapshot();
  for (int k = 0; k < 10; ++k) one.w.step();
  const std::uint64_t hash = one.w.hash();
  one.w.restore(image);
  for (int k = 0; k < 10; ++k) one.w.step();
  CHECK(one.w.hash() == hash);
}

TEST_CASE("a body floats where its density lies between those of two fluids", "[fluid][mixture]") {
  if (!kFull) return;
  Layers l("dfsph", 4, "heavy below");
  BodyDesc b;
  b.shape = make_box(Real(0.3), Real(0.2), 1)->section();
  b.density = 2500;  // half of it in either: (2500 - 1000) / (4000 - 1000)
  b.position = vec3(Real(0.5), Real(0.75), 0);
  const ObjectId id = l.w.need<Rigid>().add_body(b);
  run(l.w, 8);
  const Vec3 at = l.w.need<Rigid>().pose(id).position;
  CAPTURE(at[1]);
  // the level of the heavy fluid, which the body has displaced upwards, less what a surface loses
  CHECK(at[1] == Approx(kMixLayers * kMixSpacing + 0.3 * 0.1).margin(kMixSpacing));
}

TEST_CASE("fluids that may touch need one solver; those that may not, do not", "[fluid][mixture]") {
  World w(fluid_world(2), fluid_catalog());
  Fluid& f = w.need<Fluid>();
  FluidDesc d;
  d.name = "oil", d.solver = "dfsph";
  f.add_fluid(d);
  d.name = "water", d.solver = "pbf";
  try {
    f.add_fluid(d);
    FAIL("expected an error");
  } catch (const SceneError& e) {
    const std::string what = e.what();
    CAPTURE(what);
    CHECK(what.find("oil") != std::string::npos);
    CHECK(what.find("water") != std::string::npos);
    CHECK(what.find("solver") != std::string::npos);
  }
  CHECK(f.pool_count() == 1);
  d.group = 2, d.mask = 2;
  f.add_fluid(d);
  CHECK(f.pool_count() == 2);
}
