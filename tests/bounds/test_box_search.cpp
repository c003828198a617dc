// Every search for overlapping boxes against all pairs.
#include <algorithm>
#include <vector>

#include "base/rng.h"
#include "bounds/box_search.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Boxes on a coarse grid, where equal bounds and touching faces are common; some of them wide, flat or empty.
std::vector<Aabb> boxes_of(std::uint64_t seed, std::size_t count, int kind) {
  Rng rng(seed);
  std::vector<Aabb> boxes(count);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 at(rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-5, 5));
    Vec3 size(rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(0, 1));
    if (kind == 1) at = at.array().round(), size = size.array().round();
    if (kind == 2 && i % 17 == 0) size *= 1000;
    if (kind == 2 && i % 23 == 0) size[1] = 0;
    if (kind == 3) at *= Real(1e-6), size *= i % 5 == 0 ? Real(1e9) : Real(1e-6);
    boxes[i] = {at, at + size};
    if (kind == 2 && i % 31 == 5) boxes[i] = Aabb();
    if (kind == 3 && i % 11 == 0) boxes[i] = Aabb::everything();
  }
  return boxes;
}

std::vector<BoxPair> sorted(const Array<BoxPair>& pairs) {
  std::vector<BoxPair> list(pairs.begin(), pairs.end());
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace

TEST_CASE("a search finds each overlapping pair of boxes once", "[bounds][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(box_searches().size())));
  const int kind = GENERATE(0, 1, 2, 3);
  const std::size_t count = GENERATE(std::size_t(0), std::size_t(1), std::size_t(300));
  const auto& variant = box_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name, kind, count);
  Arena arena("test");
  const auto search = variant.make(arena, Params());
  const std::vector<Aabb> a = boxes_of(1, count, kind), b = boxes_of(2, count + 50, kind);
  std::vector<BoxPair> between, within;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j)
      if (overlaps(a[i], b[j])) between.push_back({i, j});
    for (std::uint32_t j = i + 1; j < a.size(); ++j)
      if (overlaps(a[i], a[j])) within.push_back({i, j});
  }
  Array<BoxPair> out{&arena}, again{&arena};
  search->between(a, b, out);
  CHECK(sorted(out) == between);
  search->within(a, again);
  CHECK(sorted(again) == within);
  // the same order after another question
  search->between(a, b, again);
  CHECK(std::equal(out.begin(), out.end(), again.begin(), again.end()));
}
