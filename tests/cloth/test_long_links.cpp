// Links over several edges: where they go, and that they are as long as these.
#include "cloth/long_links.h"
#include "cloth/mesh.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("long links go straight on over eight edges of a flat sheet, and are as long as these", "[cloth]") {
  World w(WorldDesc{}, kClothOnly);
  Cloth& cloth = w.need<Cloth>();
  const ObjectId id = cloth.add_cloth(sheet(25, 25, Real(2.4), Real(2.4)));
  std::vector<Vec3> rest(cloth.vertex_count(id));
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = cloth.point(id, i);
  Arena arena{"long links"};
  ClothMesh mesh{arena};
  for (std::uint32_t j = 0; j < 25; ++j)
    for (std::uint32_t i = 0; i < 25; ++i) {
      const std::uint32_t v = j * 25 + i;
      if (i < 24) mesh.links.push_back({v, v + 1, Real(0.1), 1, 0});
      if (j < 24) mesh.links.push_back({v, v + 25, Real(0.1), 1, 0});
    }
  const auto check = [&](std::size_t count) {
    const std::vector<LongLink> all = long_links(mesh, rest.data(), 625);
    CHECK(all.size() == count);
    for (const LongLink& l : all) {
      const Real apart = length(Vec3(rest[l.b] - rest[l.a]));
      CHECK(double(l.rest) == Approx(double(apart)).epsilon(1e-5));
      CHECK((apart > Real(0.39) && apart < Real(0.81)));
    }
  };
  // from every second point, as on a chessboard, to the right and downwards where at least four edges are left
  check(2 * (25 * 21 + 1) / 2);
  // where the first row is a border: from all points of three rows, none of the next, and every second of the others
  for (const ClothLink& l : mesh.links) {
    ClothEdge e{};
    e.a = l.a, e.b = l.b;
    e.triangle[0] = 0, e.triangle[1] = l.b < 25 ? kNone : 0;
    mesh.edges.push_back(e);
  }
  const std::size_t right = 3 * 21 + 11 * 11 + 10 * 10, down = 3 * 25 + 9 * 13 + 8 * 12;
  check(right + down);
}
