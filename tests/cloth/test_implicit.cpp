// What the solvers of implicit Euler promise beside the contract of solver.h: implicit reaches the minimum of the
// incremental potential, which is written here a second time; xpbd and vbd converge to it; neither adds energy; and
// both bear what nobody should ask of them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "cloth/extremes.h"
#include "cloth/mesh.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

using Point = std::array<double, 3>;
using Points = std::vector<Point>;

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double inner(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point vector_product(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Points points_of(const Cloth& cloth, ObjectId id) {
  Points x;
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) {
    const Vec3 p = cloth.point(id, i);
    x.push_back({component(p, 0), component(p, 1), component(p, 2)});
  }
  return x;
}

double largest_distance(const Points& a, const Points& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::sqrt(inner(minus(a[i], b[i]), minus(a[i], b[i]))));
  return most;
}

// Links and hinges of a sheet without ghosts, and their energy in double.
struct Elements {
  explicit Elements(const ClothDesc& d) : mesh(arena) {
    std::vector<Vec3> rest;
    std::vector<std::uint32_t> triangles;
    make_sheet(d.size, d.nx, d.ny, rest, triangles);
    mesh.triangles.assign(triangles.begin(), triangles.end());
    mesh.grid = d.nx;
    make_elements(mesh, rest, {d.stretch, d.shear < 0 ? d.stretch / 10 : d.shear, d.bend});
  }
  double energy(const Points& x) const {
    double sum = 0;
    for (const ClothLink& l : mesh.links) {
      const Point e = minus(x[l.b], x[l.a]);
      const double off = std::sqrt(inner(e, e)) - double(l.rest);
      sum += 0.5 * double(l.stiffness) * off * off;
    }
    for (const ClothHinge& h : mesh.hinges) {
      const Point e = minus(x[h.v[1]], x[h.v[0]]), n1 = vector_product(e, minus(x[h.v[2]], x[h.v[0]])),
                  n2 = vector_product(minus(x[h.v[3]], x[h.v[0]]), e);
      const double angle =
          std::atan2(inner(vector_product(n1, n2), e) / std::sqrt(inner(e, e)), inner(n1, n2)) - double(h.angle);
      sum += 0.5 * double(h.stiffness) * angle * angle;
    }
    return sum;
  }
  Arena arena{"test"};
  ClothMesh mesh;
};

WorldDesc still_world() {
  WorldDesc wd;
  wd.sleeping = false;
  wd.options.set("air_density", 0.0);
  return wd;
}

// A soft sheet that hangs from its top and is let go at 30 degrees.
ClothDesc swinging(const char* solver, std::uint32_t cells) {
  ClothDesc d = sheet(cells + 1, cells + 1, 1, 1);
  d.solver = solver;
  d.stretch = 100;
  d.bend = Real(1e-3);
  d.max_strain = kInfinity;
  d.self_collision = false;
  d.pin_names = {"top"};
  d.pose.rotation = from_axis_angle(Vec3(1, 0, 0), kPi / 3);
  return d;
}

const char* either() {
  const char* const names[] = {"implicit", "vbd"};
  return names[GENERATE(0, 1)];
}

}  // namespace

TEST_CASE("implicit ends each step where the incremental potential has no slope", "[cloth][implicit]") {
  WorldDesc wd = still_world();
  wd.substeps = 1;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = swinging("implicit", 6);
  d.substeps = 1;
  d.solver_options.set("tolerance", 1e-8);
  const ObjectId id = cloth.add_cloth(d);
  const Elements elements(d);
  const double h = w.desc().dt;
  for (int k = 0; k < 30; ++k) {
    Points goal = points_of(cloth, id);
    for (std::size_t i = 0; i < goal.size(); ++i)
      for (std::size_t n = 0; n < 3; ++n)
        goal[i][n] += h * component(cloth.velocity(id, i), static_cast<int>(n)) - (n == 1 ? 9.81 * h * h : 0);
    w.step();
    CHECK(w.events().list().empty());  // no warning
    Points x = points_of(cloth, id);
    double slope = 0, weight = 0;
    for (std::size_t i = d.nx; i < x.size(); ++i)  // behind the pinned row
      for (std::size_t n = 0; n < 3; ++n) {
        const double m = double(cloth.point_mass(id, i)), at = x[i][n], small = 1e-5;
        x[i][n] = at + small;
        const double up = elements.energy(x);
        x[i][n] = at - small;
        const double down = elements.energy(x);
        x[i][n] = at;
        const double g = m * (at - goal[i][n]) / (h * h) + (up - down) / (2 * small);
        slope += g * g / m, weight += n == 1 ? 9.81 * 9.81 * m : 0;
      }
    // in float, positions round by 1e-7: a hundred newtons per metre over a kilogram give 1e-3
    CHECK(std::sqrt(slope / weight) < (sizeof(Real) == 4 ? 5e-3 : 1e-5));
  }
}

TEST_CASE("implicit says so once when it may not iterate to its tolerance", "[cloth][implicit]") {
  World w(still_world(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = swinging("implicit", 8);
  d.stretch = 1e5;
  d.solver_options.set("iterations", 1.0);
  const ObjectId id = cloth.add_cloth(d);
  cloth.set_point(id, 80, Vec3(2, 1, 0));
  int warned = 0;
  for (int k = 0; k < 20; ++k) {
    w.step();
    for (const Event& e : w.events().list()) {
      if (e.kind != EventKind::warning || w.events().warning_code(e) != "unconverged") continue;
      ++warned;
      CHECK_THAT(w.events().warning_message(e), Catch::Contains("after 1 steps of Newton at a residual of"));
      CHECK_THAT(w.events().warning_message(e), Catch::Contains("solver_options.iterations"));
    }
  }
  CHECK(warned == 1);
}

TEST_CASE("vbd with many sweeps takes the step of implicit", "[cloth][implicit]") {
  const Real bend = GENERATE(Real(1e-3), Real(0.1));
  Points start, ends[2];
  for (const int n : {0, 1}) {
    WorldDesc wd = still_world();
    wd.substeps = 1;
    World w(wd, kClothOnly);
    Cloth& cloth = w.need<Cloth>();
    ClothDesc d = swinging(n ? "vbd" : "implicit", 8);
    d.substeps = 1;
    d.bend = bend;
    if (n) d.solver_options.set("iterations", 600.0), d.solver_options.set("relaxation", 1.5);
    const ObjectId id = cloth.add_cloth(d);
    for (std::size_t i = d.nx; i < cloth.vertex_count(id); ++i)
      cloth.set_velocity(id, i, Vec3(0, 0, static_cast<Real>(std::sin(8 * component(cloth.point(id, i), 0)))));
    start = points_of(cloth, id);
    w.step();
    ends[n] = points_of(cloth, id);
  }
  const double moved = largest_distance(start, ends[0]), apart = largest_distance(ends[0], ends[1]);
  std::printf("vbd against implicit, bend %g: %.2g of a move of %.4f m\n", double(bend), apart / moved, moved);
  CHECK(apart < 1e-3 * moved);
}

TEST_CASE("xpbd and vbd converge to implicit with the number of solver substeps", "[cloth][implicit]") {
  double apart[2][2];
  for (const int fine : {0, 1}) {
    Points ends[3];
    const char* const names[] = {"implicit", "xpbd", "vbd"};
    for (std::size_t n = 0; n < 3; ++n) {
      World w(still_world(), kClothOnly);
      Cloth& cloth = w.need<Cloth>();
      ClothDesc d = swinging(names[n], 6);
      d.substeps = fine ? 32 : 4;
      const ObjectId id = cloth.add_cloth(d);
      for (int k = 0; k < 30; ++k) w.step();
      ends[n] = points_of(cloth, id);
    }
    for (std::size_t n = 0; n < 2; ++n) apart[n][fine] = largest_distance(ends[0], ends[n + 1]);
  }
  std::printf("to implicit after .5 s: xpbd %.2g, %.2g m; vbd %.2g, %.2g m\n", apart[0][0], apart[0][1], apart[1][0],
              apart[1][1]);
  for (const auto& a : apart) {
    CHECK(a[1] < 2e-3);
    CHECK(a[1] < 0.5 * a[0] + 5e-4);
  }
}

TEST_CASE("a sheet that swings freely gains no energy: with implicit in no step, with vbd not on the whole",
          "[cloth][implicit]") {
  const char* solver = either();
  const Real stretch = GENERATE(Real(100), Real(1e4));
  CAPTURE(solver, stretch);
  World w(still_world(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = swinging(solver, 8);
  d.stretch = stretch;
  cloth.add_cloth(d);
  const auto total = [&] { return w.energy().kinetic + w.energy().potential + w.energy().elastic; };
  const double start = total();
  double last = start;
  for (int k = 0; k < 120; ++k) {
    w.step();
    const double now = total();
    CHECK(now < (std::string(solver) == "vbd" ? start + 2e-3 : last + 1e-4));  // J, of 1 J that swings
    last = now;
  }
  CHECK(last < start);
  CHECK(last > start - 1);
}

// Rows that grow from 1 cm to 3 m: what hangs from the finest has some 10^4 times its mass.
TEST_CASE("light cloth carries cloth of 10^4 times its mass", "[cloth][implicit]") {
  const char* solver = either();
  CAPTURE(solver);
  World w(still_world(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d;
  Real at = 0, size = Real(0.01);
  for (std::uint32_t row = 0; row < 8; ++row) {
    for (const int k : {0, 1}) d.vertices.push_back(Vec3(size * static_cast<Real>(k), -at, 0));
    at += size, size *= Real(2.3);
    const std::uint32_t a = 2 * row;
    if (row + 1 < 8) d.triangles.insert(d.triangles.end(), {a, a + 1, a + 2, a + 1, a + 3, a + 2});
  }
  d.solver = solver;
  d.self_collision = false;
  d.pins = {0, 1};
  const ObjectId id = cloth.add_cloth(d);
  const double start = w.energy().potential;
  const double ratio = double(cloth.point_mass(id, 15)) / double(cloth.point_mass(id, 1));
  for (int k = 0; k < 240; ++k) {
    w.step();
    REQUIRE(w.is_finite());
  }
  std::printf("%s, mass ratio %.3g: strain %.4f, %.2g J\n", solver, ratio, double(cloth.max_strain(id)),
              w.energy().kinetic);
  CHECK(ratio > 5e3);
  CHECK(cloth.max_strain(id) < 0.05);
  CHECK(w.energy().kinetic + w.energy().potential < start);
}

TEST_CASE("extremes with implicit and vbd: never a number that is not finite, no energy from nothing",
          "[cloth][implicit]") {
  const char* solver = either();
  const double stretch = GENERATE(1.0, 1e6), bend = GENERATE(0.0, 1.0);
  const auto kind = GENERATE(Extreme::one_far, Extreme::random, Extreme::one_spot, Extreme::one_line);
  run_extreme({stretch, bend, kind, false, solver, 6, kAsserts ? 40 : 120});
}
