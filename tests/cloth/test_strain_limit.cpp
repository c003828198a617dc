// max_strain: what hangs stretches no more than that, at default settings and up to 100 cells a side.
#include <algorithm>
#include <cstdio>
#include <random>

#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

int warnings(World& w) {
  int count = 0;
  for (const Event& e : w.events().list()) count += e.kind == EventKind::warning;
  return count;
}

// A sheet of 3 m that falls from flat, hung at corners.
void hang(std::uint32_t cells, const char* solver, double seconds,
          const std::vector<std::string>& corners = {"top_left", "top_right"}) {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(cells + 1, cells + 1, 3, 3);
  d.pin_names = corners;
  d.solver = solver;
  d.self_collision = false;
  const ObjectId id = cloth.add_cloth(d);
  int warned = 0;
  const int steps = static_cast<int>(seconds * 60);
  for (int k = 0; k < steps; ++k) w.step(), warned += warnings(w);
  const int rest = relax(w, id, 3, 1e-3);
  std::vector<double> strain(cloth.edge_count(id));
  for (std::size_t k = 0; k < strain.size(); ++k) strain[k] = static_cast<double>(cloth.strain(id, k));
  std::nth_element(strain.begin(), strain.begin() + strain.size() / 2, strain.end());
  const double median = strain[strain.size() / 2], worst = static_cast<double>(cloth.max_strain(id));
  std::printf(
      "3 m sheet, %s, %u cells, %zu corners: median %.4f, worst %.4f, %d solver substeps, %d steps to rest, %.4f J\n",
      solver, cells, corners.size(), median, worst, cloth.substeps(id), rest, w.energy().kinetic);
  CHECK(median <= 0.01);
  CHECK(worst <= 0.05);
  CHECK(warned == 0);
}

}  // namespace

TEST_CASE("a default sheet of 3 m hung at two corners stretches 1 % in the median and 5 % at worst",
          "[cloth][strain]") {
  hang(GENERATE(10u, 32u, 60u), "xpbd", 3);
}

TEST_CASE("the same at one corner", "[cloth][strain]") { hang(GENERATE(10u, 32u, 50u), "xpbd", 4, {"top_left"}); }

TEST_CASE("the same with vbd, and with implicit", "[cloth][strain]") {
  const std::uint32_t cells = GENERATE(10u, 24u);
  hang(cells, "vbd", 3);
  if (cells == 10) hang(cells, "implicit", 2);
}

TEST_CASE("the same of many cells", "[cloth][strain][late]") { hang(GENERATE(74u, 99u), "xpbd", 4); }

TEST_CASE("a pinned corner that a script sets anywhere gives its sheet no more energy than the material holds",
          "[cloth][strain][late]") {
  std::mt19937 random(7);
  const auto range = [&](double a, double b) {
    return Real(a + (b - a) * (static_cast<double>(random()) / 4294967296.0));
  };
  const char* const solver = GENERATE("xpbd", "mass_spring", "vbd", "implicit");
  int alarms = 0;
  double fastest = 0;
  for (int trial = 0; trial < 40; ++trial) {
    World w(WorldDesc{}, kClothOnly);
    Cloth& cloth = w.need<Cloth>();
    ClothDesc d = sheet(9, 6, Real(1.1), Real(1.3));
    d.area_density = Real(0.58), d.solver = solver;
    d.stretch = std::pow(Real(10), range(2, 4.5));
    d.pin_names = {"top_left", "top_right"};
    const ObjectId id = cloth.add_cloth(d);
    for (int k = 0, swings = int(range(20, 80)); k < swings; ++k) w.step();
    cloth.set_point(id, 0, Vec3(range(-1, 1), range(-1.8, 1), range(-1, 1)));
    for (int k = 0; k < 10; ++k) {
      w.step();
      for (const Event& e : w.events().list())
        alarms += e.kind == EventKind::warning && w.events().warning_code(e) == "diverged";
      for (std::size_t i = 0; i < cloth.vertex_count(id); ++i)
        fastest = std::max(fastest, double(length(cloth.velocity(id, i))));
    }
  }
  std::printf("corner set anywhere, %s: %d alarms, at most %.1f m/s\n", solver, alarms, fastest);
  CHECK(alarms == 0);
}
