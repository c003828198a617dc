// Gas in closed meshes: Laplace's law, volume, momentum, holes and caps.
#include <algorithm>
#include <cmath>

#include "base/double3.h"
#include "cloth/balls.h"

using namespace feder;
using namespace feder::test;

namespace {

int warnings(World& w, std::string_view code) {
  int count = 0;
  for (const Event& e : w.events().list()) count += e.kind == EventKind::warning && w.events().warning_code(e) == code;
  return count;
}

// Tension of the skin from the strain of its links: the mean of trace(stress)/2 by the virial, sum of force times
// length over four times the area.
double tension(const Cloth& cloth, ObjectId id, const ClothDesc& d) {
  double sum = 0, area = 0;
  std::vector<std::uint32_t> t;
  cloth.triangles(id, t);
  const auto x = [&](std::uint32_t i) { return wide(cloth.point(id, i)); };
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> rest_area;
  for (std::size_t k = 0; k < t.size(); k += 3) {
    area += 0.5 * length(cross(x(t[k + 1]) - x(t[k]), x(t[k + 2]) - x(t[k])));
    const auto r = [&](std::uint32_t i) { return wide(d.vertices[i]); };
    const double own = 0.5 * length(cross(r(t[k + 1]) - r(t[k]), r(t[k + 2]) - r(t[k])));
    for (std::size_t j = 0; j < 3; ++j) rest_area[std::minmax(t[k + j], t[k + (j + 1) % 3])] += own;
  }
  for (const auto& [ends, own] : rest_area) {
    const double rest = length(wide(d.vertices[ends.second]) - wide(d.vertices[ends.first]));
    const double now = length(x(ends.second) - x(ends.first));
    sum += static_cast<double>(d.stretch) * own / (rest * rest) * (now - rest) * now;
  }
  return sum / (2 * area);
}

double mean_radius(const Cloth& cloth, ObjectId id) {
  double sum = 0;
  Vec3 middle = Vec3::Zero();
  const std::size_t n = cloth.vertex_count(id);
  for (std::size_t i = 0; i < n; ++i) middle += cloth.point(id, i) / static_cast<Real>(n);
  for (std::size_t i = 0; i < n; ++i) sum += static_cast<double>((cloth.point(id, i) - middle).norm());
  return sum / static_cast<double>(n);
}

}  // namespace

TEST_CASE("the tension of a balloon's skin is p R/2 at rest", "[cloth][pressure]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const std::string solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  const double p = 400;
  CAPTURE(solver);
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = balloon(3, 0.5);
  d.solver = solver;
  d.pressure = static_cast<Real>(p);
  const ObjectId id = cloth.add_cloth(d);
  for (int k = 0; k < 40; ++k) {
    w.step();
    stop(cloth, id);
    CHECK(warnings(w, "pressure_cap") == 0);
  }
  const double laplace = p * mean_radius(cloth, id) / 2;
  CHECK(tension(cloth, id, d) == Approx(laplace).epsilon(0.03));
}

TEST_CASE("a balloon that flies keeps its momentum and angular momentum", "[cloth][pressure]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const std::string solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  CAPTURE(solver);
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = balloon(2, 0.5);
  d.solver = solver;
  d.pressure = 200;
  d.velocity = Vec3(1, Real(0.5), Real(-0.25));
  const ObjectId id = cloth.add_cloth(d);
  const Momentum before = w.momentum();
  for (int k = 0; k < 60; ++k) w.step();
  const Momentum after = w.momentum();
  double size = 0, off = 0;
  for (int k = 0; k < 3; ++k)
    size += before.linear[k] * before.linear[k], off += std::pow(after.linear[k] - before.linear[k], 2);
  CHECK(std::sqrt(off / size) < 1e-5);
  for (int k = 0; k < 3; ++k)  // kg m2/s, beside the 0.5 kg m2/s of one that turns at its speed
    CHECK(std::fabs(after.angular[k] - before.angular[k]) < 1e-5);
  CHECK(cloth.volume(id) > 0.45);
}

TEST_CASE("the volume of a closed mesh, whichever way it is wound", "[cloth][pressure]") {
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d;
  d.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 4}};
  d.triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  d.pressure = 10;
  const bool inwards = GENERATE(false, true);
  if (inwards)
    for (std::size_t t = 0; t < d.triangles.size(); t += 3) std::swap(d.triangles[t], d.triangles[t + 1]);
  const ObjectId id = cloth.add_cloth(d);
  CHECK(cloth.volume(id) == Approx(4));
  for (int k = 0; k < 10; ++k) w.step();
  CHECK(cloth.volume(id) > 4.0);  // blown up, not sucked in
}

TEST_CASE("a mesh with a hole holds no gas, and says so", "[cloth][pressure]") {
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = balloon(2, 0.5);
  const bool torn = GENERATE(false, true);
  d.pressure = 300;
  if (torn)
    d.tear_strain = Real(0.02);
  else
    d.triangles.resize(d.triangles.size() - 3);
  const ObjectId id = cloth.add_cloth(d);
  int lost = 0;
  for (int k = 0; k < 30; ++k) {
    w.step();
    lost += warnings(w, "pressure_lost");
    for (const Event& e : w.events().list())
      if (e.kind == EventKind::warning && w.events().warning_code(e) == "pressure_lost")
        CHECK_THAT(w.events().warning_message(e), Catch::Contains("300 Pa"));
  }
  CHECK(lost == 1);
  CHECK(cloth.finite());
  if (!torn) CHECK(static_cast<double>(cloth.max_strain(id)) < 1e-3);
}

TEST_CASE("pressure that skin or solver substeps do not carry is cut, and said", "[cloth][pressure]") {
  const int row = GENERATE(range(0, static_cast<int>(cloth_solvers().size())));
  const std::string solver = cloth_solvers()[static_cast<std::size_t>(row)].name;
  CAPTURE(solver);
  World w(weightless(), kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = balloon(2, 0.5);
  d.solver = solver;
  d.pressure = GENERATE(Real(1e7), Real(6000));
  d.max_substeps = 4;
  const ObjectId id = cloth.add_cloth(d);
  int capped = 0;
  for (int k = 0; k < 20; ++k) w.step(), capped += warnings(w, "pressure_cap");
  CHECK(capped == 1);
  CHECK(cloth.finite());
  CHECK(std::fabs(cloth.volume(id)) < 1e4);
}

TEST_CASE("pressure is set, saved and hashed", "[cloth][pressure]") {
  const auto make = [](World& w) {
    ClothDesc d = balloon(1, 0.5);
    d.pressure = 50;
    return w.need<Cloth>().add_cloth(d);
  };
  World w(weightless(), kClothOnly), again(weightless(), kClothOnly);
  const ObjectId id = make(w);
  make(again);
  Cloth& cloth = w.need<Cloth>();
  CHECK(w.hash() == again.hash());
  cloth.set_pressure(id, 80);
  CHECK(cloth.pressure(id) == Real(80));
  CHECK(w.hash() != again.hash());
  CHECK_THROWS_WITH(cloth.set_pressure(id, kInfinity), Catch::Contains("finite"));
  CHECK_THROWS_WITH(cloth.set_pressure(id, -1), Catch::Contains("0 or more"));
  const std::string saved = w.snapshot();
  for (int k = 0; k < 10; ++k) w.step();
  const auto hash = w.hash();
  cloth.set_pressure(id, 0);
  w.restore(saved);
  CHECK(cloth.pressure(id) == Real(80));
  for (int k = 0; k < 10; ++k) w.step();
  CHECK(w.hash() == hash);
}
