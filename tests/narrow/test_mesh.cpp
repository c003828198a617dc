// Convex shapes on triangle meshes: seams are not felt, sharp edges are, sides do not matter.
#include "base/rng.h"
#include "narrow/gjk.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

// n x n tiles of `side` in the xz plane, split along alternating diagonals; heights by `height`.
template <class Height>
ShapePtr tiles(int n, Real side, const Height& height) {
  std::vector<Vec3> v;
  std::vector<std::uint32_t> t;
  for (int z = 0; z <= n; ++z)
    for (int x = 0; x <= n; ++x) {
      const Real px = (Real(x) - Real(n) / 2) * side, pz = (Real(z) - Real(n) / 2) * side;
      v.push_back(vec3(px, height(px, pz), pz));
    }
  const auto at = [&](int x, int z) { return static_cast<std::uint32_t>(z * (n + 1) + x); };
  for (int z = 0; z < n; ++z)
    for (int x = 0; x < n; ++x) {
      const std::uint32_t a = at(x, z), b = at(x + 1, z), c = at(x + 1, z + 1), d = at(x, z + 1);
      if ((x + z) % 2)
        t.insert(t.end(), {a, c, b, a, d, c});
      else
        t.insert(t.end(), {a, d, b, b, d, c});
    }
  return make_mesh(v, t);
}

}  // namespace

TEST_CASE("shapes sliding over flush triangles are pushed straight up", "[narrow][mesh]") {
  const ShapePtr floor = tiles(8, 1, [](Real, Real) { return Real(0); });
  const ShapePtr shapes[] = {make_sphere(Real(0.5)), make_box(1, 1, 1), make_capsule(Real(0.25), Real(1.5)),
                             make_cylinder(Real(0.5), 1), make_box(Real(0.2), Real(0.2), Real(0.2))};
  const int which = GENERATE(range(0, 5));
  const Shape& shape = *shapes[which];
  const Real margin = Real(0.02);
  Rng rng(7);
  for (int i = 0; i < 500; ++i) {
    Pose pose{vec3(rng.uniform(-2, 2), 0, rng.uniform(-2, 2)), from_axis_angle(vec3(0, 1, 0), rng.uniform(-3, 3))};
    if (which == 2) pose.rotation = pose.rotation * from_axis_angle(vec3(0, 0, 1), kPi / 2);
    const Real sink = rng.uniform(Real(-0.015), Real(0.04));
    const Vec3 low = to_world(pose, shape.support(rotate_inverse(pose.rotation, vec3(0, -1, 0))));
    pose.position[1] = -low[1] + shape.radius() - sink;
    const Hit hit = collide(shape, pose, *floor, {}, margin);
    CAPTURE(which, i, sink, pose.position.transpose());
    REQUIRE(hit.count == 1);
    CHECK((hit.m[0].normal - vec3(0, -1, 0)).norm() < 1e-3);
    CHECK(deepest(hit.m, 1) == Approx(-sink).margin(1e-4));
    if (which == 1 || which == 4) CHECK(hit.m[0].count == 4);
    if (which == 2) CHECK(hit.m[0].count >= 2);
    if (which == 3) CHECK(hit.m[0].count >= 3);
  }
}

TEST_CASE("a surface holds from behind too", "[narrow][mesh]") {
  const ShapePtr floor = tiles(4, 1, [](Real, Real) { return Real(0); }), ball = make_sphere(Real(0.5));
  const Hit hit = collide(*ball, {vec3(Real(0.3), Real(-0.45), Real(0.1)), {}}, *floor, {}, Real(0.02));
  REQUIRE(hit.count == 1);
  CHECK((hit.m[0].normal - vec3(0, 1, 0)).norm() < 1e-4);
  CHECK(deepest(hit.m, 1) == Approx(-0.05).margin(1e-5));
}

TEST_CASE("a ball on a ridge feels the edge, in a valley both sides", "[narrow][mesh]") {
  const ShapePtr ball = make_sphere(Real(0.5));
  const ShapePtr ridge = tiles(4, 1, [](Real x, Real) { return -std::abs(x); });
  Hit hit = collide(*ball, {vec3(0, Real(0.49), Real(0.2)), {}}, *ridge, {}, Real(0.02));
  REQUIRE(hit.count == 1);
  CHECK((hit.m[0].normal - vec3(0, -1, 0)).norm() < 1e-3);
  CHECK(deepest(hit.m, 1) == Approx(-0.01).margin(1e-5));
  const ShapePtr valley = tiles(4, 1, [](Real x, Real) { return std::abs(x); });
  hit = collide(*ball, {vec3(0, Real(0.5) * std::sqrt(Real(2)) - Real(0.01), Real(0.2)), {}}, *valley, {}, Real(0.02));
  REQUIRE(hit.count == 2);
  for (int i = 0; i < 2; ++i) CHECK(std::abs(hit.m[i].normal[1]) == Approx(std::sqrt(0.5)).margin(1e-4));
  CHECK(hit.m[0].normal[0] * hit.m[1].normal[0] < 0);
}

TEST_CASE("a box over the border of a mesh rests on it", "[narrow][mesh]") {
  const ShapePtr floor = tiles(2, 1, [](Real, Real) { return Real(0); }), box = make_box(1, 1, 1);
  const Hit hit = collide(*box, {vec3(Real(1.2), Real(0.49), Real(0.1)), {}}, *floor, {}, Real(0.02));
  REQUIRE(hit.count >= 1);
  int up = 0;
  for (int i = 0; i < hit.count; ++i) up += hit.m[i].normal[1] < Real(-0.999);
  CHECK(up == 1);
}

TEST_CASE("moving mesh and shape together changes nothing", "[narrow][mesh]") {
  const ShapePtr hills = tiles(8, Real(0.5), [](Real x, Real z) { return Real(0.1) * x * x - Real(0.05) * x * z; });
  const ShapePtr box = make_box(Real(0.6), Real(0.4), Real(0.5));
  Rng rng(9);
  for (int i = 0; i < 100; ++i) {
    const Real x = rng.uniform(-1, 1), z = rng.uniform(-1, 1);
    const Pose pose{vec3(x, Real(0.1) * x * x - Real(0.05) * x * z + Real(0.22), z), random_rotation(rng)};
    const Pose frame{random_direction(rng) * 3, random_rotation(rng)};
    const Hit a = collide(*box, pose, *hills, {}, Real(0.01)),
              b = collide(*box, frame * pose, *hills, frame, Real(0.01));
    CAPTURE(i, a.count, b.count);
    if (a.count == 0 || deepest(a.m, a.count) > Real(0.009)) continue;
    REQUIRE(b.count >= 1);
    CHECK(deepest(a.m, a.count) == Approx(deepest(b.m, b.count)).margin(2e-3));
  }
}

TEST_CASE("a lone triangle pushes the shortest way, as a search over all directions finds it", "[narrow][mesh]") {
  const int kinds = static_cast<int>(shape_kinds().size());
  const int kind = GENERATE_COPY(range(0, kinds));
  Rng rng(static_cast<std::uint64_t>(kind) + 21);
  int pushed = 0, face_pushes = 0;
  for (const ShapePtr& shape : shape_kinds()[static_cast<std::size_t>(kind)].samples()) {
    if (!shape->convex() || shape->planar()) continue;
    const Real size = shape->extent(Vec3::Zero()), margin = Real(0.02) * size;
    for (int trial = 0; trial < 400; ++trial) {
      const Vec3 corners[3] = {random_direction(rng) * size * rng.uniform(Real(0.3), 3), random_direction(rng) * size,
                               random_direction(rng) * size * rng.uniform(Real(0.3), 2)};
      const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]);
      if (length(across) < Real(0.1) * size * size) continue;
      const std::uint32_t numbers[3] = {0, 1, 2};
      const ShapePtr mesh = make_mesh(corners, numbers);
      // over a random point of the triangle, a little in or out
      const Real u = rng.uniform(Real(-0.2), 1), v = rng.uniform(Real(-0.2), Real(1.2)) * (1 - u);
      const Vec3 front = across / length(across),
                 foot = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
      Pose pose{Vec3::Zero(), random_rotation(rng)};
      const Vec3 low = to_world(pose, shape->support(rotate_inverse(pose.rotation, -front)));
      pose.position = foot - low + front * (shape->radius() + rng.uniform(Real(-0.05), Real(0.03)) * size);

      Gap gap;
      const ConvexPair pair(Convex(*shape), pose, Convex(corners, 3), Pose{});
      const bool near = core_gap(pair, -pair.offset, double(margin) + shape->radius(), gap);
      const Real separation = near ? Real(gap.distance) - shape->radius() : kInfinity;
      const Vec3 towards = -rotate(pose.rotation, narrow(gap.normal));
      const Hit hit = collide(*shape, pose, *mesh, {}, margin);
      const Real tolerance = Real(2e-3) * size;
      CAPTURE(shape->kind(), trial, separation, margin, hit.count, dot(towards, front));
      if (!near || separation > margin - tolerance) {
        if (hit.count) CHECK(deepest(hit.m, hit.count) > margin - 2 * tolerance);
        continue;
      }
      if (dot(towards, front) < Real(0.05)) continue;  // from behind, where the side of the middle decides
      REQUIRE(hit.count == 1);
      CHECK(deepest(hit.m, 1) == Approx(separation).margin(tolerance));
      CHECK(dot(hit.m[0].normal, -towards) > Real(0.99));
      ++pushed, face_pushes += dot(towards, front) > Real(0.9999);
    }
  }
  if (pushed) CHECK(face_pushes > pushed / 10);
  if (pushed) CHECK(face_pushes < pushed * 9 / 10);
}
