// Every volume of the table: it holds what it was made of, its tests miss nothing, and it is as tight as the geometry
// of a turned box says.
#include <cmath>
#include <map>

#include "base/rng.h"
#include "bounds/polytope.h"
#include "bounds/volume.h"
#include "feder/error.h"
#include "support/catch.h"

using namespace feder;

namespace {

const VolumeKind& any_volume() {
  const int k = GENERATE(range(0, static_cast<int>(bounding_volumes().size())));
  return bounding_volumes()[static_cast<std::size_t>(k)];
}

// Rz Ry Rx.
Mat3 turned(double x, double y, double z) {
  const auto about = [](int axis, double angle) {
    Mat3 m = Mat3::Identity();
    const int i = (axis + 1) % 3, k = (axis + 2) % 3;
    m(i, i) = m(k, k) = static_cast<Real>(std::cos(angle));
    m(k, i) = static_cast<Real>(std::sin(angle)), m(i, k) = -m(k, i);
    return m;
  };
  return about(2, z) * about(1, y) * about(0, x);
}

std::vector<Vec3> box_triangles(const Vec3& size, const Mat3& turn, const Vec3& at) {
  static const int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  std::vector<Vec3> list;
  for (const auto& face : kFaces)
    for (const int corner : face) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1 ? Real(0.5) : Real(-0.5)) * size[k];
      list.push_back(at + turn * p);
    }
  return list;
}

// A cloud in a cigar, a plate, a ball, or on a line.
std::vector<Vec3> cloud(int kind, int count, Rng& rng, double scale) {
  static const Real kSizes[5][3] = {{1, 1, 1}, {5, Real(0.3), Real(0.2)}, {2, 2, 0}, {3, 0, 0}, {0, 0, 0}};
  const Mat3 turn = turned(rng.unit() * 3, rng.unit() * 3, rng.unit() * 3);
  const Vec3 at(rng.uniform(-4, 4), rng.uniform(-4, 4), rng.uniform(-4, 4));
  std::vector<Vec3> list;
  for (int i = 0; i < count; ++i) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = kSizes[kind][k] * rng.uniform(-1, 1);
    list.push_back(static_cast<Real>(scale) * (at + turn * p));
  }
  return list;
}

}  // namespace

TEST_CASE("volumes of a turned box are what geometry says", "[bounds][volume]") {
  const std::vector<Vec3> triangles = box_triangles(Vec3(1, 2, 5), turned(0.3, 0.8, 1.1), Vec3::Zero());
  std::map<std::string, double> volume;
  for (const VolumeKind& kind : bounding_volumes()) volume[kind.name] = kind.around({triangles, 3})->volume();
  CHECK(volume["obb"] == Approx(10).epsilon(0.01));
  CHECK(volume["hull"] == Approx(10).epsilon(0.01));
  CHECK(volume["aabb"] == Approx(88.96).epsilon(0.01));
  CHECK(volume["sphere"] == Approx(86.04).epsilon(0.01));
  CHECK(volume["kdop14"] == Approx(38.0).epsilon(0.01));
  CHECK(volume["kdop18"] == Approx(24.4).epsilon(0.01));
  CHECK(volume["kdop26"] == Approx(21.8).epsilon(0.01));
  CHECK(volume["aabb"] >= volume["kdop14"]);
  CHECK(volume["kdop14"] >= volume["kdop26"]);
  CHECK(volume["kdop26"] >= volume["hull"]);
}

TEST_CASE("a volume holds what it was made of and merged from, and its tests miss nothing", "[bounds][volume]") {
  const VolumeKind& kind = any_volume();
  const double scale = GENERATE(1e-3, 1.0, 1e5);
  Rng rng(5);
  for (int round = 0; round < 60; ++round) {
    const int points = 1 + static_cast<int>(rng.next() % 30);
    const std::vector<Vec3> a = cloud(round % 5, points, rng, scale), b = cloud(round / 5 % 5, points, rng, scale);
    const auto va = kind.around({a, 1}), vb = kind.around({b, 1}), both = va->merged(*vb);
    CAPTURE(kind.name, scale, round);
    for (const Vec3& p : a) {
      REQUIRE(va->contains(p));
      REQUIRE(both->contains(p));
      REQUIRE(va->meets({p, p}));
      // a volume of things that lie there meets this one
      REQUIRE(kind.around({{&p, 1}, 1})->overlaps(*va));
    }
    for (const Vec3& p : b) REQUIRE(both->contains(p));
    REQUIRE(va->overlaps(*both));
    REQUIRE(both->overlaps(*vb));
    REQUIRE(va->overlaps(*vb) == vb->overlaps(*va));
    // segments between points of either lie in the convex volume of both, and meet what has both ends
    const std::vector<Vec3> bridge{a[0], b[0]};
    REQUIRE(kind.around({bridge, 2})->overlaps(*va));
    REQUIRE(kind.around({bridge, 2})->overlaps(*vb));
  }
}

TEST_CASE("volumes tell apart what is far apart", "[bounds][volume]") {
  const VolumeKind& kind = any_volume();
  Rng rng(6);
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec3> a = cloud(round % 5, 20, rng, 1), b = cloud(round / 5 % 5, 20, rng, 1);
    for (Vec3& p : b) p += Vec3(40, 0, 0);
    const auto va = kind.around({a, 1}), vb = kind.around({b, 1});
    CAPTURE(kind.name, round);
    CHECK_FALSE(va->overlaps(*vb));
    CHECK_FALSE(va->meets({Vec3(30, -5, -5), Vec3(50, 5, 5)}));
  }
}

TEST_CASE("a plate that is a thousand million times as wide as thick is held", "[bounds][volume]") {
  const VolumeKind& kind = any_volume();
  const std::vector<Vec3> plate = box_triangles(Vec3(1e5, 1e5, Real(1e-4)), turned(0.3, 0.8, 1.1), Vec3(1, 2, 3));
  const auto v = kind.around({plate, 3});
  for (const Vec3& p : plate) CHECK(v->contains(p));
  CHECK(std::isfinite(v->volume()));
  CHECK(v->meets({Vec3(0, 1, 2), Vec3(2, 3, 4)}));
}

TEST_CASE("edges of a volume lie on it and reach as far as what it holds", "[bounds][volume]") {
  const VolumeKind& kind = any_volume();
  const Real scale = GENERATE(Real(1e-3), Real(1), Real(1e5));
  const bool round = std::string(kind.name) == "sphere";
  Rng rng(8);
  for (int k = 0; k < 40; ++k) {
    const std::vector<Vec3> points = cloud(k % 4, 4 + k / 2, rng, static_cast<double>(scale));
    const auto volume = kind.around({points, 1});
    std::vector<Vec3> ends;
    const auto add = [](void* to, const Vec3& a, const Vec3& b) {
      auto& list = *static_cast<std::vector<Vec3>*>(to);
      list.push_back(a), list.push_back(b);
      return true;
    };
    CHECK(volume->edges({add, &ends}));
    CAPTURE(kind.name, scale, k);
    REQUIRE(ends.size() >= 6);
    const Real room = Real(2e-3) * scale;
    for (const Vec3& p : ends) {
      Aabb near{p, p};
      near.grow(room);
      REQUIRE(volume->meets(near));
    }
    for (int j = 0; j < 30; ++j) {  // circles stand for a sphere along the axes only
      const Vec3 d =
          round ? Vec3((j % 2 ? 1 : -1) * Vec3::Unit(j % 3)) : Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), 1);
      const auto farthest = [&](const std::vector<Vec3>& list) {
        Real far = -kInfinity;
        for (const Vec3& p : list) far = std::max(far, dot(p, d));
        return far;
      };
      REQUIRE(farthest(ends) >= farthest(points) - room);
    }
    // the visitor may have enough
    int count = 0;
    const auto few = [](void* to, const Vec3&, const Vec3&) { return ++*static_cast<int*>(to) < 3; };
    CHECK_FALSE(volume->edges({few, &count}));
    CHECK(count == 3);
  }
}

TEST_CASE("half-spaces have each edge once", "[bounds][volume]") {
  std::vector<HalfSpace> planes;
  for (int k = 0; k < 3; ++k) {
    const Double3 n = wide(Vec3::Unit(k));
    planes.push_back({n, 1}), planes.push_back({-n, 1});
  }
  const auto measure = [&] {
    std::pair<int, double> found{0, 0};  // edges, and how long they are in all
    const auto add = [](void* to, const Vec3& a, const Vec3& b) {
      auto& [count, sum] = *static_cast<std::pair<int, double>*>(to);
      return ++count, sum += static_cast<double>(length(Vec3(b - a))), true;
    };
    CHECK(edges_within(planes, 2, {add, &found}));
    return found;
  };
  CHECK(measure() == std::pair{12, 24.0});
  planes.push_back({{1, 1, 0}, 2});  // touches an edge, and takes nothing away
  CHECK(measure().second == Approx(24));
  planes.back() = {{1, 1, 1}, 2};  // cuts a corner off
  CHECK(measure().first == 15);
  CHECK(measure().second == Approx(24 - 3 + 3 * std::sqrt(2.0)));
}

TEST_CASE("volumes refuse what is not finite, and nothing", "[bounds][volume]") {
  const VolumeKind& kind = any_volume();
  const std::vector<Vec3> bad{Vec3(0, 0, 0), Vec3(0, std::numeric_limits<Real>::quiet_NaN(), 0), Vec3(1, 0, 0)};
  CHECK_THROWS_AS(kind.around({bad, 3}), SceneError);
  CHECK_THROWS_AS(kind.around({{}, 3}), SceneError);
  CHECK_THROWS_WITH(bounding_volume("ellipsoid"), Catch::Contains("obb"));
  CHECK_THROWS_WITH(tree_build("magic"), Catch::Contains("sah"));
}
