// Views that take out what meets nothing, against all pairs.
#include <vector>

#include "base/rng.h"
#include "bounds/depth_views.h"
#include "support/catch.h"

using namespace feder;

namespace {

Aabb box_at(double x, double y, double z, double a, double b, double c) {
  const Vec3 lo(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z));
  return {lo, lo + Vec3(static_cast<Real>(a), static_cast<Real>(b), static_cast<Real>(c))};
}

// Houses of many heights along streets, some in pairs that share a wall, and a few things in the air.
std::vector<Aabb> city() {
  Rng rng(3);
  std::vector<Aabb> all;
  for (int i = 0; i < 24; ++i)
    for (int k = 0; k < 24; ++k) {
      const double wide = 10 - 5 * std::pow(0.01, rng.unit()), deep = 10 - 5 * std::pow(0.01, rng.unit()),
                   high = 3 + 40 * rng.unit() * rng.unit();
      all.push_back(box_at(10 * i, 0, 10 * k, wide, high, deep));
      if (rng.unit() < 0.05) all.push_back(box_at(10 * i + 0.5 * wide, 0, 10 * k, 0.5 * wide, 2, deep));
      if (rng.unit() < 0.05) all.push_back(box_at(10 * i, 60 + 20 * rng.unit(), 10 * k, 2, 1, 2));
    }
  return all;
}

std::vector<Aabb> gas(double size, double ratio) {
  Rng rng(4);
  std::vector<Aabb> all;
  for (int n = 0; n < 300; ++n) {
    const double s = size * std::pow(ratio, -rng.unit());
    all.push_back(box_at(rng.unit(), rng.unit(), rng.unit(), s, s, s));
  }
  return all;
}

std::vector<Aabb> far_away(std::vector<Aabb> all) {
  for (Aabb& b : all) b.lo += Vec3::Constant(Real(1e5)), b.hi += Vec3::Constant(Real(1e5));
  return all;
}

std::vector<std::uint32_t> left_of(const std::vector<Aabb>& all, int pixels, int threads) {
  Arena arena("bounds");
  JobPool jobs(threads);
  Array<Aabb> boxes(all.begin(), all.end(), &arena);
  Array<std::uint32_t> set(&arena);
  for (std::uint32_t i = 0; i < all.size(); ++i) set.push_back(i);
  DepthViews views(arena);
  CHECK(views.cull(boxes, pixels, set, jobs) >= all.size());
  CHECK(std::is_sorted(set.begin(), set.end()));
  return {set.begin(), set.end()};
}

}  // namespace

TEST_CASE("views of any resolution leave all boxes that meet another", "[bounds][depth_views]") {
  const std::vector<Aabb> scenes[] = {city(),
                                      far_away(city()),
                                      gas(0.03, 1),
                                      gas(0.3, 1),
                                      gas(0.2, 1e9),
                                      far_away(gas(30, 4)),
                                      std::vector<Aabb>(20, box_at(1, 2, 3, 1, 1, 1)),
                                      {box_at(0, 0, 0, 1, 1, 1), box_at(1, 0, 0, 1, 1, 1), box_at(5, 0, 0, 0, 0, 0)}};
  for (const std::vector<Aabb>& all : scenes)
    for (const int pixels : {16, 64, 256, 1024}) {
      const std::vector<std::uint32_t> left = left_of(all, pixels, 1);
      std::size_t lost = 0;
      for (std::uint32_t a = 0; a < all.size(); ++a)
        for (std::uint32_t b = a + 1; b < all.size(); ++b)
          if (overlaps(all[a], all[b]))
            lost +=
                !std::binary_search(left.begin(), left.end(), a) || !std::binary_search(left.begin(), left.end(), b);
      CAPTURE(all.size(), pixels, left.size());
      CHECK(lost == 0);
    }
}

TEST_CASE("the finer the views of a city, the more leaves the set", "[bounds][depth_views]") {
  const std::vector<Aabb> all = city();
  std::size_t last = all.size() + 1, meeting = 0;
  for (const Aabb& a : all)
    meeting += std::any_of(all.begin(), all.end(), [&](const Aabb& b) { return &a != &b && overlaps(a, b); });
  for (const int pixels : {16, 64, 256, 1024}) {
    const std::size_t left = left_of(all, pixels, 1).size();
    CAPTURE(pixels, left, meeting, all.size());
    CHECK(left < last);
    CHECK(left >= meeting);
    last = left;
  }
  CHECK(last < meeting + all.size() / 50);
}

TEST_CASE("views leave the same set on any number of threads", "[bounds][depth_views][threads]") {
  for (const std::vector<Aabb>& all : {city(), gas(0.1, 1)})
    for (const int threads : {2, 4}) CHECK(left_of(all, 64, threads) == left_of(all, 64, 1));
}
