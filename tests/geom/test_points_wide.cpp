// Kernels on points eight at a time, both builds, against plain loops: the same bits, and of equals the first.
#include "base/rng.h"
#include "base/wide.h"
#include "geom/hull.h"
#include "geom/points_wide.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<Lane8x3> grouped(const std::vector<Vec3>& points) {
  std::vector<Lane8x3> groups((points.size() + kLanes - 1) / kLanes);
  for (std::size_t i = 0; i < groups.size() * kLanes; ++i) {
    const Vec3& p = points[i < points.size() ? i : 0];
    Lane8x3& g = groups[i / kLanes];
    g.x.v[i % kLanes] = p[0], g.y.v[i % kLanes] = p[1], g.z.v[i % kLanes] = p[2];
  }
  return groups;
}

Vec3 random_point(Rng& rng, bool coarse) {
  Vec3 p;
  for (int k = 0; k < 3; ++k) p[k] = coarse ? Real(int(rng.next() % 3)) - 1 : rng.uniform(-1, 1);
  return p;
}

}  // namespace

TEST_CASE("wide kernels on points give the bits of a plain loop", "[geom][wide]") {
  const bool wide = GENERATE(false, true);
  if (wide && !runs_avx2()) return;
  const PointKernel& kernel = wide ? kPointsAvx2 : kPointsPlain;
  const bool coarse = GENERATE(false, true);  // a grid of few places: equals are common
  Rng rng(3);
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<Vec3> points(1 + rng.next() % 40);
    for (Vec3& p : points) p = random_point(rng, coarse);
    const std::vector<Lane8x3> groups = grouped(points);
    const auto count = static_cast<unsigned>(groups.size());
    const Vec3 d = random_point(rng, coarse);
    unsigned first = 0;
    for (unsigned i = 1; i < points.size(); ++i)
      if (dot(points[i], d) > dot(points[first], d)) first = i;
    CAPTURE(wide, coarse, points.size(), trial);
    REQUIRE(kernel.farthest(groups.data(), count, d[0], d[1], d[2]) == first);

    Real rotation[9], lo[3], hi[3];
    for (Real& r : rotation) r = rng.uniform(-1, 1);
    kernel.bounds(groups.data(), count, rotation, lo, hi);
    for (int k = 0; k < 3; ++k) {
      const Vec3 row = vec3(rotation[3 * k], rotation[3 * k + 1], rotation[3 * k + 2]);
      Real least = kInfinity, most = -kInfinity;
      for (const Vec3& p : points) least = std::min(least, dot(p, row)), most = std::max(most, dot(p, row));
      REQUIRE(lo[k] == least);
      REQUIRE(hi[k] == most);
    }
  }
  const std::vector<Lane8x3> corners = grouped({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)});
  const Real none = std::numeric_limits<Real>::quiet_NaN();
  CHECK(kernel.farthest(corners.data(), 1, none, 0, 0) < 3);
}

TEST_CASE("a hull answers with its first farthest corner", "[geom][wide]") {
  Rng rng(5);
  std::vector<Vec3> cloud;
  for (int i = 0; i < 50; ++i) {
    const Vec3 p = random_point(rng, false);
    cloud.push_back(p / length(p));
  }
  const Hull hull(build_hull(cloud), cloud);
  for (int i = 0; i < 200; ++i) {
    const Vec3 d = random_point(rng, false);
    const Vec3* best = &hull.data().corners[0];
    for (const Vec3& c : hull.data().corners)
      if (dot(c, d) > dot(*best, d)) best = &c;
    CHECK(hull.support(d) == *best);
  }
}
