// A point that moves against triangles that move: the first meeting is found, at the right time and place, and a closed
// surface lets nothing in.
#include "base/rng.h"
#include "geom/swept_triangle.h"
#include "support/catch.h"

using namespace feder;

namespace {

Vec3 random(Rng& rng, Real most) {
  const Real x = rng.uniform(-most, most), y = rng.uniform(-most, most), z = rng.uniform(-most, most);
  return vec3(x, y, z);
}

}  // namespace

TEST_CASE("a point meets a triangle that comes at it where and when it should", "[geom][swept]") {
  const Vec3 before[3] = {vec3(0, 1, 0), vec3(3, 1, 0), vec3(0, 1, 3)};
  const Vec3 after[3] = {vec3(0, -1, 0), vec3(3, -1, 0), vec3(0, -1, 3)};
  const Vec3 at = vec3(1, 0, Real(0.5));
  SweptHit hit;
  REQUIRE(SweptTriangle(at, at, before, after).first(hit));
  CHECK(hit.when == Approx(0.5));
  CHECK(hit.weight[1] == Approx(1.0 / 3));
  CHECK(hit.weight[2] == Approx(0.5 / 3));
  CHECK(hit.from_front);  // the normal, by the order of the corners, points down
  SweptHit earlier;
  earlier.when = 0.4;
  CHECK_FALSE(SweptTriangle(at, at, before, after).first(earlier));
  SweptHit beside;
  CHECK_FALSE(SweptTriangle(vec3(2, 0, 2), vec3(2, 0, 2), before, after).first(beside));
}

TEST_CASE("no path leads into a closed surface whose corners move without meeting its triangles", "[geom][swept]") {
  const int faces[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  Rng rng(7);
  for (int k = 0; k < 4000; ++k) {
    Vec3 before[6], after[6];
    for (int i = 0; i < 6; ++i) {
      Vec3 tip = Vec3::Zero();
      tip[i / 2] = i % 2 ? Real(-1) : Real(1);
      before[i] = tip + random(rng, Real(0.3)), after[i] = tip + random(rng, Real(0.3)) + vec3(2, 0, 0);
    }
    // from far outside to the middle; in every other one through a corner or along an edge
    const Vec3 to = vec3(2, 0, 0);
    Vec3 from = 3 * normalized_or(random(rng, 1), vec3(0, 1, 0));
    if (k % 4 == 1) from = before[0] + 2 * before[0];
    if (k % 4 == 3) from = before[0] + 2 * (before[0] + before[2]);
    int met = 0;
    for (const auto& f : faces) {
      const Vec3 a[3] = {before[f[0]], before[f[1]], before[f[2]]}, b[3] = {after[f[0]], after[f[1]], after[f[2]]};
      SweptHit hit;
      if (!SweptTriangle(from, to, a, b).first(hit)) continue;
      ++met;
      // there the point lies in the triangle
      const Real t = static_cast<Real>(hit.when);
      Vec3 p = from + t * (to - from);
      for (int i = 0; i < 3; ++i) p -= hit.weight[i] * (a[i] + t * (b[i] - a[i]));
      REQUIRE(length(p) < Real(1e-4));
    }
    CAPTURE(k);
    REQUIRE(met > 0);
  }
}
