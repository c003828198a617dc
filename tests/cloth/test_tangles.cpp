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
