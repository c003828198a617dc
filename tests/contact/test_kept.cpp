// A search that is kept over steps: folded cloth at rest is seldom searched, does not cross itself, and goes on from a
// snapshot, with other threads and after an edit as it must.
#include "cloth/crossings.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

// A sheet whose far half hangs over the near one, which is held.
struct Fold {
  explicit Fold(int threads) : w(desc(threads), kClothOnly), cloth(w.need<Cloth>()) {
    constexpr std::uint32_t n = 24;
    ClothDesc d = sheet(n, n, 1, 1);
    d.thickness = Real(0.01), d.bend = Real(1e-5), d.damping = Real(0.02);
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n / 2; ++i) d.pins.push_back(n * j + i);
    id = cloth.add_cloth(d);
    for (std::size_t i = 0; i < n * n; ++i) {
      const Vec3 x = cloth.point(id, i);
      if (x[0] > 0) cloth.set_point(id, i, Vec3(-x[0], Real(0.06), x[2]));
    }
  }
  static WorldDesc desc(int threads) {
    WorldDesc wd;
    wd.sleeping = false, wd.threads = threads;
    return wd;
  }
  // Searches of so many steps.
  double run(int steps) {
    double sum = 0;
    for (int k = 0; k < steps; ++k) {
      w.step();
      for (const Residual& r : w.residuals())
        if (r.name == "contact.searches") sum += r.value;
    }
    return sum;
  }
  std::size_t crossings() const {
    Soup s;
    s.add(cloth, id);
    return count_crossings(s);
  }
  World w;
  Cloth& cloth;
  ObjectId id;
};

}  // namespace

TEST_CASE("folded cloth at rest is searched less than once in a step", "[contact][cloth]") {
  Fold f(1);
  CHECK(f.run(20) > 0);
  std::size_t crossings = 0;
  for (int k = 0; k < 22; ++k) f.run(10), crossings += f.crossings();
  const double searches = f.run(60);
  CAPTURE(searches);
  CHECK(searches < 60);
  CHECK(crossings + f.crossings() == 0);
  // what was at rest is lifted: the kept candidates do not cover that
  const Vec3 up = f.cloth.point(f.id, 24 * 12 + 20) + Vec3(0, Real(0.03), 0);
  f.cloth.set_point(f.id, 24 * 12 + 20, up);
  CHECK(f.run(1) >= 1);
  f.run(30);
  CHECK(f.crossings() == 0);
}

TEST_CASE("a kept search goes on from a snapshot and with more threads as it was", "[contact][cloth][snapshot]") {
  Fold f(1);
  f.run(220);
  const std::string image = f.w.snapshot();
  const double searches = f.run(40);
  const std::uint64_t hash = f.w.hash();
  f.w.restore(image);
  CHECK(f.run(40) == searches);
  CHECK(f.w.hash() == hash);
  for (const int threads : {2, 4}) {
    Fold other(threads);
    other.run(220);
    CHECK(other.run(40) == searches);
    CHECK(other.w.hash() == hash);
  }
}
