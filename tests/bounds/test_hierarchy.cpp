// Every volume with every build against all pairs, over moving boxes in seven arrangements.
#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "bounds/box_tree.h"
#include "bounds/volume.h"
#include "feder/error.h"
#include "study/moving_boxes.h"
#include "support/catch.h"

using namespace feder;

namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Boxes that move, as their eight corners.
struct Moving {
  Moving(const std::string& kind, std::uint32_t count) : boxes_(kind, count, {.crowd = 1}) {}
  void step() { ++step_; }
  Aabb box(std::uint32_t i) const { return boxes_.box(i, 0.2, step_); }
  ItemPoints items() {
    points_.clear();
    for (std::uint32_t i = 0; i < count(); ++i) {
      const Aabb b = box(i);
      for (int k = 0; k < 8; ++k)
        points_.push_back(Vec3(k & 1 ? b.hi[0] : b.lo[0], k & 2 ? b.hi[1] : b.lo[1], k & 4 ? b.hi[2] : b.lo[2]));
    }
    return {points_, 8};
  }
  Pairs all_pairs() const {
    Pairs out;
    for (std::uint32_t a = 0; a < count(); ++a)
      for (std::uint32_t b = a + 1; b < count(); ++b)
        if (overlaps(box(a), box(b))) out.emplace_back(a, b);
    return out;
  }
  std::uint32_t count() const { return boxes_.count(); }

 private:
  MovingBoxes boxes_;
  int step_ = 0;
  std::vector<Vec3> points_;
};

// Found by the hierarchy, less what only its volumes say: the boxes of the items decide.
Pairs found_pairs(const Hierarchy& h, const Moving& m, HierarchyCost& cost) {
  struct Out {
    const Moving& m;
    Pairs pairs;
    bool ordered = true;
  } out{m, {}};
  h.pairs({[](void* to, std::uint32_t a, std::uint32_t b) {
             Out& o = *static_cast<Out*>(to);
             o.ordered = o.ordered && a < b;
             if (overlaps(o.m.box(a), o.m.box(b))) o.pairs.emplace_back(a, b);
           },
           &out},
          &cost);
  REQUIRE(out.ordered);
  std::sort(out.pairs.begin(), out.pairs.end());
  return out.pairs;
}

std::vector<std::uint32_t> found_in(const Hierarchy& h, const Moving& m, const Aabb& box) {
  std::vector<std::uint32_t> list;
  h.query(box, {[](void* to, std::uint32_t i) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(i); }, &list});
  std::sort(list.begin(), list.end());
  REQUIRE(std::adjacent_find(list.begin(), list.end()) == list.end());
  std::erase_if(list, [&](std::uint32_t i) { return !overlaps(m.box(i), box); });
  return list;
}

// Of those volumes with every build, over the same motion.
void run(const std::vector<const VolumeKind*>& kinds, const std::string& arrangement, std::uint32_t count, int steps,
         std::uint32_t leaf) {
  Moving m(arrangement, count);
  struct Case {
    const VolumeKind* kind;
    const TreeBuild* build;
    std::unique_ptr<Hierarchy> tree;
  };
  std::vector<Case> cases;
  for (const VolumeKind* kind : kinds)
    for (const TreeBuild& build : tree_builds()) {
      cases.push_back({kind, &build, kind->hierarchy()});
      cases.back().tree->build(m.items(), build, leaf);
      REQUIRE(cases.back().tree->size() == count);
    }
  HierarchyCost cost;
  Rng rng(3);
  for (int s = 0; s < steps; ++s) {
    const Pairs all = m.all_pairs();
    const Vec3 at(rng.uniform(-1, 5), rng.uniform(-1, 5), rng.uniform(-1, 5));
    const Aabb box{at, at + Vec3::Constant(rng.uniform(0, 3))};
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < count; ++i)
      if (overlaps(m.box(i), box)) expected.push_back(i);
    for (const Case& c : cases) {
      CAPTURE(c.kind->name, c.build->name, arrangement, count, s);
      REQUIRE((found_pairs(*c.tree, m, cost) == all));
      REQUIRE((found_in(*c.tree, m, box) == expected));
    }
    m.step();
    for (const Case& c : cases) c.tree->refit(m.items());
  }
}

// All volumes, or all but the dearest by far.
std::vector<const VolumeKind*> volumes(bool with_hull) {
  std::vector<const VolumeKind*> list;
  for (const VolumeKind& kind : bounding_volumes())
    if (with_hull || kind.name != std::string("hull")) list.push_back(&kind);
  return list;
}

}  // namespace

TEST_CASE("every volume with every build finds what all pairs find, while things move", "[bounds][hierarchy]") {
  const std::string arrangement =
      GENERATE(from_range(std::begin(MovingBoxes::kArrangements), std::end(MovingBoxes::kArrangements)));
  const int steps = kAsserts ? 5 : 20;
  for (const std::uint32_t count : {0u, 1u, 2u}) run(volumes(true), arrangement, count, steps, 1);
  run(volumes(false), arrangement, 257, steps, 4);
  run({&bounding_volume("hull")}, arrangement, kAsserts ? 20 : 60, 4, 4);
}

TEST_CASE("the same of 4096 boxes over 200 steps", "[bounds][hierarchy][.map]") {
  const std::string arrangement =
      GENERATE(from_range(std::begin(MovingBoxes::kArrangements), std::end(MovingBoxes::kArrangements)));
  const std::uint32_t count = arrangement == "identical" ? 257 : 4096;
  run(volumes(false), arrangement, count, 200, 2);
  run({&bounding_volume("hull")}, arrangement, 257, 20, 2);
}

TEST_CASE("builds put every item into one leaf that is not too full", "[bounds][hierarchy]") {
  const auto& build =
      tree_builds()[static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(tree_builds().size()))))];
  const std::string arrangement =
      GENERATE(from_range(std::begin(MovingBoxes::kArrangements), std::end(MovingBoxes::kArrangements)));
  const std::uint32_t leaf = GENERATE(1u, 4u, 9u);
  for (const std::uint32_t count : {0u, 1u, 3u, 200u}) {
    const Moving m(arrangement, count);
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < count; ++i) boxes.push_back(m.box(i));
    const TreeShape tree = build.build(boxes, leaf);
    CAPTURE(build.name, arrangement, leaf, count);
    std::vector<std::uint32_t> order = tree.order;
    std::sort(order.begin(), order.end());
    REQUIRE(order.size() == count);
    for (std::uint32_t i = 0; i < count; ++i) REQUIRE(order[i] == i);
    for (const TreeNode& n : tree.nodes) {
      REQUIRE((!n.leaf() || n.count <= leaf));
      if (n.leaf()) continue;
      const TreeNode &a = tree.nodes[n.child], &b = tree.nodes[n.child + 1];
      REQUIRE((a.first == n.first && a.first + a.count == b.first && a.count + b.count == n.count));
      REQUIRE((a.count > 0 && b.count > 0));
    }
  }
}

TEST_CASE("what has grown loose is built anew, and nothing else", "[bounds][hierarchy]") {
  const auto& build =
      tree_builds()[static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(tree_builds().size()))))];
  Moving still("gas", 200), moving("gas", 200);
  const auto h = bounding_volume("aabb").hierarchy();
  h->build(still.items(), build, 2);
  h->refit(still.items());
  CHECK(h->rebuilt() == 0);
  for (int k = 0; k < 20; ++k) moving.step();
  HierarchyCost refitted, fresh;
  h->refit(moving.items());
  CAPTURE(build.name);
  CHECK(h->rebuilt() > 0);
  const Pairs found = found_pairs(*h, moving, refitted);
  const auto anew = bounding_volume("aabb").hierarchy();
  anew->build(moving.items(), build, 2);
  CHECK(found == found_pairs(*anew, moving, fresh));
  CHECK(refitted.nodes < 2 * fresh.nodes);
}

TEST_CASE("a hierarchy keeps what it has where points are not finite", "[bounds][hierarchy]") {
  Moving m("gas", 20);
  const auto h = bounding_volume("obb").hierarchy();
  h->build(m.items(), tree_build("sah"), 2);
  HierarchyCost cost;
  const Pairs before = found_pairs(*h, m, cost);
  std::vector<Vec3> bad(m.items().points.begin(), m.items().points.end());
  bad[11][1] = std::numeric_limits<Real>::infinity();
  CHECK_THROWS_WITH(h->build({bad, 8}, tree_build("sah"), 2), Catch::Contains("item 2"));
  CHECK_THROWS_AS(h->refit({bad, 8}), SceneError);
  CHECK(found_pairs(*h, m, cost) == before);
}

// A ribbon of 20,000 triangles along a helix, 50 times as wide as long and askew to all axes.
TEST_CASE("oriented boxes spare triangle tests where triangles lie askew", "[bounds][hierarchy]") {
  std::vector<Vec3> points;
  const auto edge = [](int k, bool outer) {
    const double t = k * 0.0063, r = outer ? 1.25 : 1;
    return Vec3(static_cast<Real>(r * std::cos(t)), static_cast<Real>(0.03 * t + (outer ? 0.2 : 0)),
                static_cast<Real>(r * std::sin(t)));
  };
  for (int k = 0; k < 10000; ++k) {
    for (const Vec3& p : {edge(k, false), edge(k, true), edge(k + 1, false)}) points.push_back(p);
    for (const Vec3& p : {edge(k, true), edge(k + 1, true), edge(k + 1, false)}) points.push_back(p);
  }
  const ItemPoints items{points, 3};
  std::vector<Aabb> boxes(items.count());
  for (std::uint32_t i = 0; i < items.count(); ++i)
    for (const Vec3& p : items.of(i)) boxes[i].include(p);
  Arena arena("test");
  BoxTree present(arena);
  present.build(boxes);
  const auto obb = bounding_volume("obb").hierarchy();
  obb->build(items, tree_build("sah"), 4);
  Rng rng(8);
  std::size_t now = 0, then = 0;
  for (int k = 0; k < 500; ++k) {  // boxes of things that lie on the ribbon
    const int at = static_cast<int>(rng.next() % 10000);
    const Vec3 p = edge(at, false) + rng.uniform(0, 1) * (edge(at, true) - edge(at, false));
    const Aabb box{p - Vec3::Constant(Real(0.02)), p + Vec3::Constant(Real(0.02))};
    present.query(box, [&](std::uint32_t) { ++now; });
    obb->query(box, {[](void* n, std::uint32_t) { ++*static_cast<std::size_t*>(n); }, &then});
  }
  CAPTURE(now, then);
  CHECK(static_cast<double>(then) < 0.7 * static_cast<double>(now));
}
