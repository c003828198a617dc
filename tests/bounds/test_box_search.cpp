// Every search for overlapping boxes against all pairs.
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

std::vector<BoxPair> listed(const Array<BoxPair>& pairs) { return {pairs.begin(), pairs.end()}; }

void compare(BoxSearch& search, Arena& arena, const std::vector<Aabb>& a, const std::vector<Aabb>& b) {
  std::vector<BoxPair> between, within;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size(); ++j)
      if (overlaps(a[i], b[j])) between.push_back({i, j});
    for (std::uint32_t j = i + 1; j < a.size(); ++j)
      if (overlaps(a[i], a[j])) within.push_back({i, j});
  }
  Array<BoxPair> out{&arena};
  out.push_back({7, 7});  // replaced, not kept
  search.between(a, b, out);
  REQUIRE(listed(out) == between);
  search.within(a, out);
  REQUIRE(listed(out) == within);
}

}  // namespace

TEST_CASE("a search finds each overlapping pair of boxes once, ascending", "[bounds][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(box_searches().size())));
  const int kind = GENERATE(0, 1, 2, 3);
  const std::size_t count = GENERATE(std::size_t(0), std::size_t(1), std::size_t(300));
  const auto& variant = box_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name, kind, count);
  Arena arena("test");
  const auto search = variant.make(arena, Params());
  const std::vector<Aabb> a = boxes_of(1, count, kind), b = boxes_of(2, count + 50, kind);
  compare(*search, arena, a, b);
  compare(*search, arena, b, a);
}

TEST_CASE("a search finds the same whatever was asked before", "[bounds][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(box_searches().size())));
  const int kind = GENERATE(0, 1, 2, 3);
  const Real drift = static_cast<Real>(GENERATE(0.0, 1e-3, 0.3));
  const auto& variant = box_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name, kind, drift);
  Arena arena("test");
  const auto search = variant.make(arena, Params());
  std::vector<Aabb> a = boxes_of(3, 120, kind), b = boxes_of(4, 150, kind);
  Rng rng(5);
  for (int call = 0; call < 60; ++call) {
    CAPTURE(call);
    compare(*search, arena, a, b);
    for (std::vector<Aabb>* list : {&a, &b}) {
      const std::vector<Aabb> fresh = boxes_of(rng.next(), list->size(), kind);
      for (std::size_t i = 0; i < list->size(); ++i) {
        Aabb& box = (*list)[i];
        const Vec3 d(rng.uniform(-drift, drift), rng.uniform(-drift, drift), rng.uniform(-drift, drift));
        if (rng.unit() < 0.3) box.lo += d, box.hi += d;                                      // most stay where they are
        if (rng.unit() < 0.01) box = fresh[i];                                               // some jump
        if (rng.unit() < 0.01) box.hi = box.lo + rng.uniform(0, 2) * Vec3(box.hi - box.lo);  // some grow or shrink
      }
      if (call % 20 == 19) list->resize(list->size() - 7);
    }
  }
}

TEST_CASE("a search does not allocate once it is warm", "[bounds][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(box_searches().size())));
  const auto& variant = box_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name);
  Arena arena("test");
  const auto search = variant.make(arena, Params());
  std::vector<Aabb> a = boxes_of(6, 300, 0);
  const std::vector<Aabb> one(300, Aabb{Vec3::Constant(-1), Vec3::Constant(1)});
  Array<BoxPair> out{&arena};
  search->between(one, one, out), search->within(one, out);  // everything overlaps everything
  search->between(a, a, out), search->within(a, out);
  const std::uint64_t before = arena.allocations();
  Rng rng(8);
  for (int call = 0; call < 30; ++call) {
    for (Aabb& box : a) {
      const Vec3 d(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      box.lo += d, box.hi += d;
    }
    search->between(a, a, out), search->within(a, out);
  }
  CHECK(arena.allocations() == before);
}
