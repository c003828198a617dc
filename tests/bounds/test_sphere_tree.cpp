// The tree of spheres: how many of its nodes it writes. Its pairs: test_box_search.cpp.
#include <cmath>
#include <vector>

#include "base/rng.h"
#include "bounds/sphere_tree.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Boxes of the triangles' size on a sheet that is bent to a half-pipe, `side` x `side`.
std::vector<Aabb> half_pipe(int side) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double angle = 3.14159 * i / side;
      const Vec3 at(static_cast<Real>(std::cos(angle)), static_cast<Real>(std::sin(angle)),
                    static_cast<Real>(3.0 * j / side));
      Aabb box{at, at};
      box.grow(Real(2) / static_cast<Real>(side));
      boxes.push_back(box);
    }
  return boxes;
}

void shift(Aabb& box, const Vec3& d) { box.lo += d, box.hi += d; }

}  // namespace

TEST_CASE("a sphere tree writes only the nodes above what moved", "[bounds]") {
  const int side = 100, dent = GENERATE(1, 10);  // a dent of 10 x 10 is 1 % of the leaves
  const double depth = GENERATE(0.15, 0.3);      // m, of boxes of .04
  Arena arena("test");
  SphereTree tree(arena);
  std::vector<Aabb> boxes = half_pipe(side);
  tree.update(boxes);
  CHECK(tree.node_updates() == tree.node_count());  // the full fit
  tree.update(boxes);
  CHECK(tree.node_updates() == tree.node_count());  // nothing moved: nothing more
  double worst = 0;
  for (const int corner : {0, 13, 45, 77, 90}) {
    std::vector<Aabb> dented = boxes;
    const std::uint64_t before = tree.node_updates(), builds = tree.builds();
    for (int i = corner; i < corner + dent; ++i)
      for (int j = corner; j < corner + dent; ++j)
        shift(dented[static_cast<std::size_t>(side * i + j)], Vec3(0, static_cast<Real>(-depth), 0));
    tree.update(dented);
    CHECK(tree.builds() == builds);
    const double share = static_cast<double>(tree.node_updates() - before) / static_cast<double>(tree.node_count());
    worst = std::max(worst, share);
    CHECK(share > 0);
    tree.update(boxes);  // back again
  }
  CAPTURE(dent, depth, worst, tree.node_count());
  INFO("share of the nodes written: " << worst);
  CHECK(worst <= 0.05);
}

TEST_CASE("what trembles within its sphere writes no node, what all moves writes all", "[bounds]") {
  Arena arena("test");
  SphereTree tree(arena);
  std::vector<Aabb> boxes = half_pipe(40);
  tree.update(boxes);
  std::uint64_t before = tree.node_updates();
  Rng rng(2);
  std::vector<Aabb> near = boxes;
  for (Aabb& box : near) {
    const Real d = Real(1e-3);  // m, of boxes of .1 m
    shift(box, Vec3(rng.uniform(-d, d), rng.uniform(-d, d), rng.uniform(-d, d)));
  }
  tree.update(near);
  CHECK(tree.node_updates() == before);
  for (Aabb& box : near) shift(box, Vec3(1, 0, 0));
  tree.update(near);
  CHECK(tree.node_updates() == before + tree.node_count());
  CHECK(tree.builds() == 1);
  // its pieces thrown about: the spheres of the old tree no longer fit
  for (Aabb& box : near) shift(box, Vec3(rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-9, 9)));
  tree.update(near);
  CHECK(tree.builds() == 2);
}
