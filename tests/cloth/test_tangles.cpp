// Crossings of a cloth with itself: the count against the independent one, and how they come apart.
#include <cmath>

#include "base/rng.h"
#include "cloth/crossings.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

std::size_t counted(const Cloth& cloth, ObjectId id) {
  Soup s;
  s.add(cloth, id);
  return count_crossings(s);
}

}  // namespace

TEST_CASE("tangles() is the independent count", "[cloth]") {
  const int kind = GENERATE(0, 1, 2, 3, 4);
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(15, 15, 1, 1);
  // tilted, so that flat is flat within rounding only
  d.pose.rotation = kind == 0 ? Quat(1, 0, 0, 0) : Quat(Real(0.6), Real(0.48), Real(0.64), 0);
  const ObjectId id = cloth.add_cloth(d);
  Rng rng(3);
  for (std::size_t i = 0; i < 225; ++i) {
    const Vec3 x = cloth.point(id, i);
    const Vec3 r(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1));
    if (kind == 2) cloth.set_point(id, i, r);                  // all random
    if (kind == 3) cloth.set_point(id, i, x + Real(0.1) * r);  // rough
    if (kind == 4 && i % 15 > 7) cloth.set_point(id, i, cloth.point(id, i - 2 * (i % 15 - 7)) + Real(0.02) * r);
  }
  const std::size_t expected = counted(cloth, id);
  CAPTURE(kind, expected);
  CHECK(cloth.tangles(id) == expected);
  CHECK((kind > 1) == (expected > 0));
}

namespace {

// A sheet with its first edge put through it, beside the corner of a cell; or all of it shaken; or all at random.
enum class Tangle { poke, rough, random };

void tangle(Cloth& cloth, ObjectId id, std::uint32_t n, Tangle how) {
  Rng rng(3);
  const Vec3 through = cloth.point(id, 3 * n + 3) + Vec3(Real(0.03), 0, Real(0.02));
  for (std::size_t i = 0; i < n * n; ++i) {
    const Vec3 r(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1));
    if (how == Tangle::poke && i < 2) cloth.set_point(id, i, through + Vec3(0, i == 0 ? Real(-0.03) : Real(0.03), 0));
    if (how == Tangle::rough) cloth.set_point(id, i, cloth.point(id, i) + Real(0.1) * r);
    if (how == Tangle::random) cloth.set_point(id, i, r);
  }
}

}  // namespace

TEST_CASE("crossings come apart, and their number only falls", "[cloth]") {
  const auto how = GENERATE(Tangle::poke, Tangle::rough);
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(sheet(15, 15, 1, 1));
  tangle(cloth, id, 15, how);
  const double before = w.energy().kinetic + w.energy().elastic + w.energy().potential;
  std::size_t last = cloth.tangles(id);
  REQUIRE(last > 0);
  int rises = 0, k = 0;
  for (; k < 240 && last > 0; ++k) {
    w.step();
    const std::size_t now = cloth.tangles(id);
    rises += now > last;
    last = now;
  }
  CAPTURE(int(how), k, last);
  CHECK(rises == 0);
  CHECK(last == 0);
  for (; k < 240; ++k) w.step();
  CHECK(cloth.tangles(id) == 0);
  CHECK(double(cloth.max_strain(id)) < 0.1);
  CHECK(w.energy().kinetic + w.energy().elastic + w.energy().potential < before);
}

TEST_CASE("what crosses itself comes back through itself where that is ignored", "[cloth]") {
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(7, 7, 1, 1);
  d.inside = "ignore";
  const ObjectId id = cloth.add_cloth(d);
  tangle(cloth, id, 7, Tangle::random);
  for (int k = 0; k < 300; ++k) w.step();
  CHECK(w.is_finite());
  CHECK(cloth.tangles(id) == 0);
  CHECK(double(cloth.max_strain(id)) < 0.05);
}

TEST_CASE("a crumpled sheet does not cross itself, whatever finds its candidates", "[cloth]") {
  const char* const self = GENERATE("swept_boxes", "hash");
  WorldDesc wd;
  wd.sleeping = false;
  World w(wd, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  ClothDesc d = sheet(12, 12, 1, 1);
  d.self = self;
  const ObjectId id = cloth.add_cloth(d);
  Rng rng(9);
  for (std::size_t i = 0; i < 144; ++i) {  // towards its middle
    const Vec3 x = cloth.point(id, i);
    cloth.set_velocity(id, i, Vec3(-6 * x[0], rng.uniform(-2, 2), -6 * x[2]));
  }
  std::size_t worst = 0;
  for (int k = 0; k < 40; ++k) {
    w.step();
    worst = std::max(worst, counted(cloth, id));
  }
  CAPTURE(self);
  CHECK(worst == 0);
}

TEST_CASE("a search of self-contact that is not there is named", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  ClothDesc d = sheet(4, 4, 1, 1);
  d.self = "hsah";
  CHECK_THROWS_WITH(w.need<Cloth>().add_cloth(d), Catch::Contains("hash"));
  d.self = "", d.inside = "in";
  CHECK_THROWS_WITH(w.need<Cloth>().add_cloth(d), Catch::Contains("'guard' or 'ignore'"));
}
