// Every index of meshes, and every volume and build of "bvh": triangles in boxes and hits of rays are those of the mesh
// that chooses nothing, in the same order and to the bit.
#include <cmath>

#include "base/rng.h"
#include "feder/error.h"
#include "geom/closest.h"
#include "geom/mesh_index.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Soup {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    for (const Vec3& p : {a, b, c}) triangles.push_back(static_cast<std::uint32_t>(points.size())), points.push_back(p);
  }
};

Vec3 anywhere(Rng& rng, Real size) {
  return Vec3(rng.uniform(-size, size), rng.uniform(-size, size), rng.uniform(-size, size));
}

// Ground, a soup of triangles of many sizes, a helix of thin ones, a fan of long ones, one plane, one triangle.
Soup soup(const std::string& kind) {
  Soup s;
  Rng rng(4);
  if (kind == "one") s.add(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1));
  if (kind == "ground" || kind == "flat") {
    const auto at = [&](int i, int k) {
      const Real x = Real(i) * Real(0.5), z = Real(k) * Real(0.5);
      return Vec3(x, kind == "flat" ? Real(0) : Real(0.5) * std::sin(x) * std::cos(z), z);
    };
    for (int i = -10; i < 10; ++i)
      for (int k = -10; k < 10; ++k)
        s.add(at(i, k), at(i, k + 1), at(i + 1, k)), s.add(at(i + 1, k), at(i, k + 1), at(i + 1, k + 1));
  }
  if (kind == "sizes")
    for (int i = 0; i < 400; ++i) {
      const Real size = std::pow(Real(10), rng.uniform(-2, Real(0.7)));
      const Vec3 at = anywhere(rng, 5);
      s.add(at + anywhere(rng, size), at + anywhere(rng, size), at + anywhere(rng, size));
    }
  if (kind == "helix")
    for (int k = 0; k < 400; ++k) {
      const auto edge = [](int n, Real r) {
        const Real t = Real(n) * Real(0.05);
        return Vec3(r * std::cos(t), Real(0.2) * t, r * std::sin(t));
      };
      s.add(edge(k, 3), edge(k, 4), edge(k + 1, 3));
    }
  if (kind == "fan")
    for (int k = 0; k < 300; ++k) {
      const Real t = Real(k) * Real(0.02);
      s.add(Vec3::Zero(), Vec3(8 * std::cos(t), Real(k % 3), 8 * std::sin(t)),
            Vec3(8 * std::cos(t + Real(0.02)), Real(k % 3), 8 * std::sin(t + Real(0.02))));
    }
  return s;
}

std::vector<MeshIndex> choices() {
  std::vector<MeshIndex> all;
  for (const TriangleIndexKind& kind : triangle_indexes()) {
    all.push_back({kind.name, "", "", 0});
    all.push_back({kind.name, "", "", 2});
  }
  for (const char* volume : {"sphere", "aabb", "obb", "kdop14", "kdop18", "kdop26"})
    all.push_back({"bvh", volume, "sah", 1});
  for (const char* build : {"top_down", "sah", "bottom_up", "insertion", "morton"}) all.push_back({"", "", build, 3});
  return all;
}

ShapePtr mesh_of(const Soup& s, const MeshIndex& choice) {
  return make_shape("mesh", {.points = s.points, .triangles = s.triangles, .mesh_index = choice});
}

std::vector<std::uint32_t> inside(const Shape& mesh, const Aabb& box) {
  std::vector<std::uint32_t> list;
  mesh.triangles_in(
      box, [](void* to, std::uint32_t i) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(i); }, &list);
  return list;
}

}  // namespace

TEST_CASE("every index finds the triangles that the mesh finds without one", "[geom][mesh_index]") {
  const std::string kind = GENERATE("one", "ground", "flat", "sizes", "helix", "fan");
  const Soup s = soup(kind);
  const ShapePtr plain = mesh_of(s, {});
  for (const MeshIndex& choice : choices()) {
    const ShapePtr mesh = mesh_of(s, choice);
    CAPTURE(kind, choice.index, choice.volume, choice.build, choice.leaf);
    // by boxes, of points up to the whole: what knows more than boxes may leave out what only boxes meet
    const bool tight = choice.index == "bsp" || (choice.volume != "" && choice.volume != "aabb");
    Rng rng(5);
    for (int k = 0; k < 300; ++k) {
      const Vec3 at = anywhere(rng, 6),
                 size = Vec3::Constant(k % 3 == 0 ? Real(0) : rng.uniform(0, k % 7 == 0 ? 9 : 1));
      const Aabb box{at - size, at + size};
      const std::vector<std::uint32_t> found = inside(*mesh, box), expected = inside(*plain, box);
      REQUIRE(std::is_sorted(found.begin(), found.end()));
      if (!tight) {
        REQUIRE(found == expected);
        continue;
      }
      REQUIRE(std::includes(expected.begin(), expected.end(), found.begin(), found.end()));
      for (const std::uint32_t i : expected) {  // what comes to within the box is found
        const Triangle& t = plain->triangle(i);
        const Vec3 on = closest_on_triangle(at, t.a, t.b, t.c);
        if ((Vec3(on - at).cwiseAbs().array() <= size.array()).all())
          REQUIRE(std::binary_search(found.begin(), found.end(), i));
      }
    }
    for (int k = 0; k < 300; ++k) {
      Vec3 from = anywhere(rng, 8), ray = anywhere(rng, 16);
      if (k % 4 == 0) ray = Vec3(0, ray[1], 0);
      RayHit a, b;
      const bool hit = plain->raycast(from, ray, a);
      REQUIRE(mesh->raycast(from, ray, b) == hit);
      if (hit) REQUIRE((a.fraction == b.fraction && a.normal == b.normal));
      Vec3 n, m;
      const Real d = plain->distance(from, 1, n);
      if (d < 1) {
        REQUIRE(mesh->distance(from, 1, m) == d);
        REQUIRE(n == m);
      } else {
        REQUIRE(mesh->distance(from, 1, m) >= 1);
      }
    }
    CHECK(mesh->arguments().mesh_index.volume == choice.volume);
    CHECK(mesh->describe().find(choice.index.empty() ? "bvh" : choice.index) == 0);
  }
}

TEST_CASE("every index shows its volumes level by level", "[geom][mesh_index]") {
  const std::string kind = GENERATE("one", "ground", "sizes", "helix", "fan");
  const Soup s = soup(kind);
  std::vector<MeshIndex> all = choices();
  all.push_back({}), all.push_back({"bvh", "hull", "", 0});
  struct Seen {
    Aabb box;
    std::size_t edges = 0, most = 1'000'000;
  };
  const auto see = [](void* to, const Vec3& a, const Vec3& b) {
    Seen& seen = *static_cast<Seen*>(to);
    seen.box.include(a), seen.box.include(b);
    return ++seen.edges < seen.most;
  };
  for (const MeshIndex& choice : all) {
    const ShapePtr mesh = mesh_of(s, choice);
    CAPTURE(kind, choice.index, choice.volume, choice.build, choice.leaf);
    const Aabb whole = mesh->bounds({});
    Seen top;
    int level = 0;
    for (bool deeper = mesh->volumes_at(0, see, &top); deeper && level < 12;) {
      Seen seen;
      deeper = mesh->volumes_at(++level, see, &seen);
      CAPTURE(level);
      REQUIRE(seen.edges > 0);
      REQUIRE(is_finite(seen.box.lo));
      REQUIRE(is_finite(seen.box.hi));
      REQUIRE(overlaps(seen.box, whole));
    }
    if (choice.index == "bvh" || choice.index.empty()) CHECK((level > 0) == (kind != "one"));
    const Real room = Real(1e-4) * (whole.hi - whole.lo).maxCoeff();
    CHECK((top.box.lo.array() <= whole.lo.array() + room).all());
    CHECK((top.box.hi.array() >= whole.hi.array() - room).all());
    // below the last level it is shown again
    Seen below;
    if (choice.index != "bsp") CHECK_FALSE(mesh->volumes_at(1000, see, &below));
    Seen few;
    few.most = 4;
    mesh->volumes_at(level, see, &few);
    CHECK(few.edges == 4);
  }
}

TEST_CASE("a mesh knows an order from back to front when its index is a partition", "[geom][mesh_index]") {
  const Soup s = soup("sizes");
  const auto add_area = [](void* to, std::uint32_t, std::span<const Vec3> corners) {
    for (std::size_t k = 2; k < corners.size(); ++k)
      *static_cast<double*>(to) +=
          static_cast<double>(length(cross(corners[k - 1] - corners[0], corners[k] - corners[0]))) / 2;
  };
  for (const MeshIndex& choice : choices()) {
    const ShapePtr mesh = mesh_of(s, choice);
    double seen = 0, whole = 0;
    CAPTURE(choice.index);
    CHECK(mesh->back_to_front(Vec3(9, 2, 1), add_area, &seen) == (choice.index == "bsp"));
    for (const std::uint32_t i : inside(*mesh, Aabb::everything())) {
      const Triangle& t = mesh->triangle(i);
      const Vec3 corners[3] = {t.a, t.b, t.c};
      add_area(&whole, i, corners);
    }
    if (choice.index == "bsp") CHECK(seen == Approx(whole).epsilon(1e-4));
  }
}

TEST_CASE("choices that do not exist are errors with the known ones", "[geom][mesh_index]") {
  const Soup s = soup("one");
  CHECK_THROWS_WITH(mesh_of(s, {"hash", "", "", 0}), Catch::Contains("octree"));
  CHECK_THROWS_WITH(mesh_of(s, {"", "ellipsoid", "", 0}), Catch::Contains("kdop26"));
  CHECK_THROWS_WITH(mesh_of(s, {"bvh", "", "best", 0}), Catch::Contains("morton"));
  CHECK_THROWS_WITH(mesh_of(s, {"grid", "obb", "", 0}), Catch::Contains("bvh"));
}
