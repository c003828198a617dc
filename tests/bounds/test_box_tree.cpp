// The tree of boxes against all pairs.
#include <algorithm>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "bounds/box_tree.h"
#include "support/catch.h"

using namespace feder;

namespace {

std::vector<Aabb> boxes(int count, Rng& rng, bool coarse) {
  std::vector<Aabb> list;
  for (int i = 0; i < count; ++i) {
    Vec3 lo, size;
    // on a coarse grid equal middles and touching faces are common
    for (int k = 0; k < 3; ++k) {
      const double x = rng.unit() * 8, d = rng.unit();
      lo[k] = static_cast<Real>(coarse ? static_cast<int>(x) : x), size[k] = coarse ? Real(1) : static_cast<Real>(d);
    }
    Aabb b;
    b.lo = lo, b.hi = lo + size;
    list.push_back(b);
  }
  return list;
}

void compare(BoxTree& tree, const std::vector<Aabb>& list, Rng& rng, bool coarse) {
  for (const Aabb& b : boxes(40, rng, coarse)) {
    std::vector<std::uint32_t> found, expected;
    tree.query(b, [&](std::uint32_t i) { found.push_back(i); });
    for (std::uint32_t i = 0; i < list.size(); ++i)
      if (overlaps(list[i], b)) expected.push_back(i);
    std::sort(found.begin(), found.end());
    REQUIRE(found == expected);
  }
  std::size_t all = 0;
  tree.query(Aabb::everything(), [&](std::uint32_t) { ++all; });
  REQUIRE(all == list.size());
  // pairs: what queries find with the items' own boxes, in their order
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  Pairs found, expected;
  tree.pairs([&](std::uint32_t a, std::uint32_t b) { found.emplace_back(a, b); });
  for (std::uint32_t a = 0; a < list.size(); ++a)
    tree.query(list[a], [&](std::uint32_t b) {
      if (b > a) expected.emplace_back(a, b);
    });
  REQUIRE(found == expected);
}

}  // namespace

TEST_CASE("a box tree finds exactly the overlapping items, each once, also after a refit", "[bounds]") {
  const int count = GENERATE(0, 1, 4, 5, 8, 9, 12, 16, 17, 40, 130, 257);
  const bool coarse = GENERATE(false, true);
  Arena arena("test");
  Rng rng(11);
  BoxTree tree(arena);
  std::vector<Aabb> list = boxes(count, rng, coarse);
  tree.build(list);
  CHECK(tree.size() == list.size());
  compare(tree, list, rng, coarse);
  for (int round = 0; round < 3; ++round) {
    list = boxes(count, rng, coarse);
    const std::uint64_t allocations = arena.allocations();
    tree.refit(list);
    CHECK(arena.allocations() == allocations);
    compare(tree, list, rng, coarse);
  }
}

TEST_CASE("one box against many meets what it overlaps", "[bounds]") {
  Rng rng(12);
  const bool coarse = GENERATE(false, true);
  std::vector<Aabb> list = boxes(200, rng, coarse);
  list.push_back(Aabb::everything()), list.push_back(Aabb{});
  for (const Aabb& a : list) {
    const BoxQuery query(a);
    for (const Aabb& b : list) REQUIRE(query.meets(b) == overlaps(b, a));
  }
}
