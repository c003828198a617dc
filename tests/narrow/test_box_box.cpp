// Box against box beyond the contract: exact normals of stacks, point counts, nearly parallel edges, cost.
#include <cstdio>
#include <ctime>

#include "base/rng.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

int collide(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, Real margin, Manifold* out) {
  static const NarrowPhase narrow("auto");
  PairCache cache;
  return narrow.collide(a, pa, b, pb, margin, cache, out);
}

}  // namespace

TEST_CASE("stacked boxes touch in four corners with an exact normal", "[narrow][box]") {
  const ShapePtr box = make_box(1, 1, 1);
  const Real shift = GENERATE(Real(0), Real(0.5), Real(-0.3));
  Manifold m[kMaxManifolds];
  REQUIRE(collide(*box, {vec3(3, 10, 7), {}}, *box, {vec3(3 + shift, Real(10.99), 7), {}}, Real(0.02), m) == 1);
  CHECK(m[0].normal == vec3(0, 1, 0));
  REQUIRE(m[0].count == 4);
  Real width = 0;
  for (int k = 0; k < 4; ++k) {
    CHECK(m[0].points[k].separation == Approx(-0.01).margin(2e-6));
    CHECK(m[0].points[k].position[1] == Approx(10.495).margin(2e-6));
    for (int l = 0; l < k; ++l) {
      width = std::max(width, std::abs(m[0].points[k].position[0] - m[0].points[l].position[0]));
      CHECK(m[0].points[k].feature != m[0].points[l].feature);
    }
  }
  CHECK(width == Approx(1 - std::abs(shift)).margin(1e-3));
}

TEST_CASE("features of a resting box stay the same under small motion", "[narrow][box]") {
  const ShapePtr box = make_box(1, 1, 1);
  Rng rng(3);
  Manifold first[kMaxManifolds], m[kMaxManifolds];
  const Vec3 up = vec3(Real(0.1), 1, Real(0.2));
  REQUIRE(collide(*box, {}, *box, {up, {}}, Real(0.02), first) == 1);
  for (int i = 0; i < 100; ++i) {
    const Pose p{up + random_direction(rng) * Real(1e-3), from_axis_angle(random_direction(rng), Real(1e-3))};
    REQUIRE(collide(*box, {}, *box, p, Real(0.02), m) == 1);
    REQUIRE(m[0].count == 4);
    for (int k = 0; k < 4; ++k) {
      int seen = 0;
      for (int l = 0; l < 4; ++l) seen += m[0].points[k].feature == first[0].points[l].feature;
      CHECK(seen == 1);
    }
  }
}

TEST_CASE("crossed edges touch in one point along their cross product", "[narrow][box]") {
  const ShapePtr box = make_box(1, 1, 1);
  const Real diagonal = std::sqrt(Real(2));
  const Quat about_z = from_axis_angle(vec3(0, 0, 1), kPi / 4), about_x = from_axis_angle(vec3(1, 0, 0), kPi / 4);
  Manifold m[kMaxManifolds];
  REQUIRE(collide(*box, {Vec3::Zero(), about_z}, *box, {vec3(0, diagonal - Real(0.01), 0), about_x}, 0, m) == 1);
  REQUIRE(m[0].count == 1);
  CHECK((m[0].normal - vec3(0, 1, 0)).norm() < 1e-5);
  CHECK(m[0].points[0].separation == Approx(-0.01).margin(1e-5));
  CHECK((m[0].points[0].position - vec3(0, diagonal / 2 - Real(0.005), 0)).norm() < 1e-4);
}

// Depth by the 15 axes in plain form: the largest gap, normalised, no preferences.
TEST_CASE("nearly parallel edges and turned faces keep the depth", "[narrow][box]") {
  const ShapePtr a = make_box(1, 1, 1), b = make_box(2, Real(0.5), 1);
  Rng rng(11);
  for (int i = 0; i < 3000; ++i) {
    const Real tilt = std::pow(Real(10), rng.uniform(-7, -1));
    const Pose pa{random_direction(rng), random_rotation(rng)};
    Pose pb{vec3(0, 0, 0), pa.rotation * from_axis_angle(random_direction(rng), tilt)};
    const Vec3 d = random_direction(rng);
    pb.position = pa.position;
    pb.position -= d * (gap_along(*a, pa, *b, pb, d) + rng.uniform(0, Real(0.1)));
    Real best = -kInfinity;
    const Mat3 ra = to_matrix(pa.rotation), rb = to_matrix(pb.rotation);
    for (int k = 0; k < 15; ++k) {
      const Vec3 axis = k < 3   ? Vec3(ra.col(k))
                        : k < 6 ? Vec3(rb.col(k - 3))
                                : cross(ra.col((k - 6) / 3), rb.col(k % 3));
      if (length(axis) < Real(1e-2)) continue;
      best = std::max(best, gap_along(*a, pa, *b, pb, axis / length(axis)));
      best = std::max(best, gap_along(*a, pa, *b, pb, -axis / length(axis)));
    }
    Manifold m[kMaxManifolds];
    const int count = collide(*a, pa, *b, pb, Real(0.01), m);
    CAPTURE(i, tilt, best);
    if (best > Real(0.0101)) CHECK(count == 0);
    if (best < Real(0.005)) {
      REQUIRE(count == 1);
      CHECK(deepest(m, 1) == Approx(best).margin(2.5e-3));
    }
  }
}

TEST_CASE("cost of box against box", "[.][bench]") {
  const ShapePtr box = make_box(1, 1, 1);
  const char* algorithm = GENERATE("auto", "gjk");
  const bool turned = GENERATE(false, true);
  const NarrowPhase narrow(algorithm);
  Rng rng(5);
  std::vector<Pose> a, b;
  for (int i = 0; i < 1024; ++i) {
    const Vec3 p = random_direction(rng) * 50;
    a.push_back({p, turned ? random_rotation(rng) : from_axis_angle(random_direction(rng), Real(1e-4))});
    const Vec3 off =
        turned ? Vec3(random_direction(rng) * Real(1.1)) : vec3(i % 2 ? Real(0.5) : Real(-0.5), Real(0.999), 0);
    b.push_back({p + off, turned ? random_rotation(rng) : from_axis_angle(random_direction(rng), Real(1e-4))});
  }
  std::vector<PairCache> cache(a.size());
  Manifold m[kMaxManifolds];
  const std::clock_t start = std::clock();
  int points = 0;
  for (int round = 0; round < 200; ++round)
    for (std::size_t i = 0; i < a.size(); ++i)
      if (narrow.collide(*box, a[i], *box, b[i], Real(0.02), cache[i], m)) points += m[0].count;
  const double ns =
      1e9 * double(std::clock() - start) / CLOCKS_PER_SEC;  // of this process, not of the clock on the wall
  std::printf("box_box %s %s: %.0f ns per call, %.2f points\n", algorithm, turned ? "turned" : "stacked", ns / 204800,
              points / 204800.0);
  CHECK(points > 0);
}
