// Crossings by the hierarchy against all pairs, on meshes where touching and flat positions are common.
#include "base/rng.h"
#include "geom/crossings.h"
#include "geom/predicates.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Mesh {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles, ends;
};

Mesh sheet_of(std::uint32_t n) {
  Mesh m;
  for (std::uint32_t i = 0; i < n * n; ++i) m.points.push_back(Vec3(Real(i % n), 0, Real(i / n)));
  for (std::uint32_t j = 0; j + 1 < n; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      for (const std::uint32_t v : {a, a + n, a + 1, a + 1, a + n, a + n + 1}) m.triangles.push_back(v);
      for (const std::uint32_t v : {a, a + 1, a, a + n, a + 1, a + n}) m.ends.push_back(v);
    }
  return m;
}

}  // namespace

TEST_CASE("crossings are those of all pairs", "[geom]") {
  const int kind = GENERATE(0, 1, 2, 3);
  Mesh m = sheet_of(9);
  Rng rng(11);
  for (Vec3& p : m.points) {
    const Real x = rng.uniform(0, 8), y = rng.uniform(0, 8), z = rng.uniform(0, 8);
    if (kind == 1) p = Vec3(x, y, z);
    if (kind == 2) p = Vec3(Real(int(x) / 2), Real(int(y) / 2), Real(int(z) / 2));      // on a lattice
    if (kind == 3) p = p[0] > 4 ? Vec3(8 - p[0] + x / 8, y / 8 - Real(0.5), p[2]) : p;  // folded, a little rough
  }
  const CrossingMesh mesh{m.points, m.triangles, m.ends.data(), 2, static_cast<std::uint32_t>(m.ends.size() / 2)};
  Arena arena("test");
  CrossingSearch search(arena);
  Array<Crossing> found{&arena};
  for (const Aabb& where : {Aabb::everything(), Aabb{Vec3(1, -1, 1), Vec3(4, 3, 5)}}) {
    search.find(mesh, where, found);
    std::vector<Crossing> all;
    for (std::uint32_t e = 0; e < mesh.edges; ++e)
      for (std::uint32_t t = 0; t < m.triangles.size() / 3; ++t) {
        const std::uint32_t *v = &m.triangles[3 * t], a = m.ends[2 * e], b = m.ends[2 * e + 1];
        bool shares = false;
        for (int k = 0; k < 3; ++k) shares = shares || v[k] == a || v[k] == b;
        Aabb edge{m.points[a], m.points[a]}, triangle{m.points[v[0]], m.points[v[0]]};
        edge.include(m.points[b]), triangle.include(m.points[v[1]]), triangle.include(m.points[v[2]]);
        if (shares || !overlaps(edge, where) || !overlaps(triangle, where)) continue;
        if (passes_through(m.points[a], m.points[b], m.points[v[0]], m.points[v[1]], m.points[v[2]]))
          all.push_back({e, t});
      }
    CAPTURE(kind, all.size());
    CHECK(std::vector<Crossing>(found.begin(), found.end()) == all);
    CHECK((kind == 0) == all.empty());
  }
}
