// xpbd and mass_spring against closed forms: free fall, catenary, cantilever, stretch.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("a cloth falls as a point does, without strain, whatever its stiffness and damping", "[cloth]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const char* solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  CAPTURE(solver);
  WorldDesc wd;
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(9, 7, 1, Real(0.8));
  d.solver = solver;
  d.damping = Real(0.05);
  d.velocity = Vec3(1, 2, Real(-0.5));
  const ObjectId id = cloth.add_cloth(d);
  const Vec3 start = cloth.point(id, 5);
  const int steps = 120;
  for (int k = 0; k < steps; ++k) w.step();
  const double t = steps * wd.dt, g = 9.81;
  const Vec3 x = cloth.point(id, 5) - start, v = cloth.velocity(id, 5);
  // each solver substep rounds the velocity by half a unit at most, often to the same side: a quarter of that worst
  // case
  const double small = static_cast<double>(steps * wd.substeps * cloth.substeps(id));
  const double tolerance = static_cast<double>(kEpsilon) * std::max(160.0, small / 8);
  CHECK(component(x, 0) == Approx(t).epsilon(tolerance));
  CHECK(component(x, 1) == Approx(2 * t - g * t * t / 2).epsilon(tolerance));
  CHECK(component(x, 2) == Approx(-t / 2).epsilon(tolerance));
  CHECK(component(v, 1) == Approx(2 - g * t).epsilon(tolerance));
  CHECK(std::fabs(static_cast<double>(cloth.max_strain(id))) < 300 * static_cast<double>(kEpsilon));
}

// theta'' = -Gamma (1 - s) cos theta, theta(0) = 0, theta'(1) = 0: drop and horizontal extent of a clamped strip under
// its own weight, Gamma = area density g L^3/bend. Solved here by shooting, to compare with published numbers first.
namespace {
void elastica(double gamma, double& drop, double& reach) {
  const auto shoot = [&](double curvature, double& h, double& w) {
    const int n = 4000;
    double a = 0, k = curvature;
    h = w = 0;
    for (int i = 0; i < n; ++i) {
      const double ds = 1.0 / n, s = i * ds;
      const auto slope = [&](double at, double angle) { return -gamma * (1 - at) * std::cos(angle); };
      const double a1 = k, k1 = slope(s, a), a2 = k + ds / 2 * k1, k2 = slope(s + ds / 2, a + ds / 2 * a1),
                   a3 = k + ds / 2 * k2, k3 = slope(s + ds / 2, a + ds / 2 * a2), a4 = k + ds * k3,
                   k4 = slope(s + ds, a + ds * a3);
      const double next = a + ds / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
      h += ds / 6 * (std::sin(a) + 4 * std::sin((a + next) / 2) + std::sin(next));
      w += ds / 6 * (std::cos(a) + 4 * std::cos((a + next) / 2) + std::cos(next));
      a = next, k += ds / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return k;
  };
  double lo = 0, hi = 60;
  for (int i = 0; i < 80; ++i) {
    const double mid = (lo + hi) / 2;
    (shoot(mid, drop, reach) < 0 ? lo : hi) = mid;
  }
}
}  // namespace

TEST_CASE("the elastica of this test is the published one", "[cloth]") {
  const double table[][3] = {{1, 0.12347, 0.99125}, {10, 0.70020, 0.65635}, {50, 0.90792, 0.24501}};
  for (const auto& row : table) {
    double drop = 0, reach = 0;
    elastica(row[0], drop, reach);
    CHECK(drop == Approx(row[1]).epsilon(1e-4));
    CHECK(reach == Approx(row[2]).epsilon(1e-4));
  }
}

namespace {
const char* each_solver() {
  return cloth_solvers()[static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(cloth_solvers().size()))))].name;
}

// A clamped strip of 1 m in 40 segments, of default cloth but for its weight.
ClothDesc cantilever(const char* solver, double gamma) {
  ClothDesc d = sheet(41, 3, 1, Real(0.05));
  d.area_density = 1;
  d.bend = static_cast<Real>(9.81 / gamma);
  d.pin_names = {"left_clamped"};
  d.solver = solver;
  return d;
}

void check_elastica(const Cloth& cloth, ObjectId id, double gamma) {
  double drop = 0, reach = 0;
  elastica(gamma, drop, reach);
  const Vec3 tip = cloth.point(id, 40 + 41), root = cloth.point(id, 41);
  std::printf("cantilever Gamma %g: drop %.4f (elastica %.4f), reach %.4f (%.4f), %d solver substeps\n", gamma,
              component(root - tip, 1), drop, component(tip - root, 0), reach, cloth.substeps(id));
  CHECK(component(root - tip, 1) == Approx(drop).epsilon(0.03));
  CHECK(component(tip - root, 0) == Approx(reach).epsilon(0.03));
}
}  // namespace

namespace {
void hang_cantilever(const std::string& solver, double gamma) {
  if (solver == "mass_spring") return;  // its springs across two cells do not bend like a plate
  CAPTURE(solver, gamma);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(cantilever(solver.c_str(), gamma));
  relax(w, id, gamma > 10 ? 5 : 3);
  check_elastica(cloth, id, gamma);
}
}  // namespace

TEST_CASE("a clamped strip of 40 segments hangs as the elastica", "[cloth]") {
  hang_cantilever(each_solver(), GENERATE(0.5, 10.0, 50.0));
}

TEST_CASE("a clamped strip hangs as the elastica at other loads", "[cloth][late]") {
  hang_cantilever(each_solver(), GENERATE(1.0, 5.0));
}

TEST_CASE("a damped strip comes to rest as the elastica within 10 s", "[cloth][late]") {
  const double gamma = GENERATE(0.5, 1.0, 5.0, 10.0, 50.0);
  CAPTURE(gamma);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = cantilever("xpbd", gamma);
  d.damping = Real(0.6);  // s; the stiff ones carry less, which is said
  const ObjectId id = cloth.add_cloth(d);
  for (int k = 0; k < 600; ++k) w.step();
  CHECK(w.energy().kinetic < 1e-6);  // J, of 0.05 kg
  check_elastica(cloth, id, gamma);
}

TEST_CASE("a strip hung at both ends sags as the catenary", "[cloth]") {
  const std::string solver = each_solver();
  const double length = GENERATE(1.1, 1.5, 2.0, 3.0);
  const double sag = length == 1.1 ? 0.20030 : length == 1.5 ? 0.50263 : length == 2 ? 0.79639 : 1.33416;
  if (solver == "mass_spring" && length < 3) return;  // takes hundreds of solver substeps
  constexpr std::uint32_t kLinks = 40;
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(kLinks + 1, 3, static_cast<Real>(length), static_cast<Real>(2 * length / kLinks));
  d.bend = 0;
  d.pin_names = {"left", "right"};
  d.solver = solver;
  const ObjectId id = cloth.add_cloth(d);
  // a V without strain; ends pushed together instead would knot the strip, which can stay so
  const double depth = std::sqrt(length * length - 1) / 2;
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) {
    const double s = static_cast<double>(i % (kLinks + 1)) / kLinks;
    cloth.set_point(
        id, i,
        Vec3(static_cast<Real>(s - 0.5), static_cast<Real>(depth * (std::fabs(2 * s - 1) - 1)), cloth.point(id, i)[2]));
  }
  const int steps = relax(w, id, 12);
  const double found = -component(cloth.point(id, kLinks + 1 + kLinks / 2), 1);
  std::printf("catenary %s length %g: sag %.5f (%.5f), %d solver substeps, %d steps to rest\n", solver.c_str(), length,
              found, sag, cloth.substeps(id), steps);
  CAPTURE(solver, length);
  CHECK(found == Approx(sag).epsilon(0.01));
}

TEST_CASE("a sheet that turns freely at 10 rad/s keeps its angular momentum, also where it folds onto itself",
          "[cloth][late]") {
  const std::string solver = each_solver();
  const bool tumbles = GENERATE(false, true);
  CAPTURE(solver, tumbles);
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(21, 21, 1, 1);
  d.solver = solver;
  const ObjectId id = cloth.add_cloth(d);
  const Vec3 axis = tumbles ? Vec3(0, 0, 10) : Vec3(0, 10, 0);  // rad/s
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) cloth.set_velocity(id, i, cross(axis, cloth.point(id, i)));
  const Momentum before = w.momentum();
  const int seconds = solver == "xpbd" || solver == "vbd" ? 10 : 1;  // the others take long
  for (int k = 0; k < 60 * seconds; ++k) w.step();
  const Momentum after = w.momentum();
  double all = 0, off = 0;
  for (int k = 0; k < 3; ++k)
    all += before.angular[k] * before.angular[k], off += std::pow(after.angular[k] - before.angular[k], 2);
  std::printf("sheet at 10 rad/s, %s%s: angular momentum off by %.2g\n", solver.c_str(), tumbles ? ", tumbling" : "",
              std::sqrt(off / all));
  CHECK(std::sqrt(off / all) < 1e-4);
}
