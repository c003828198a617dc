// Closed forms of distances, standing manifolds, sweeps and overlaps; sizes from 1e-4 m to 1e4 m.
#include "base/rng.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

Real distance(const Shape& a, const Vec3& at, const Shape& b) { return closest_points(a, {at, {}}, b, {}).distance; }

}  // namespace

TEST_CASE("distances have closed forms at every size", "[narrow][gjk]") {
  const Real s = GENERATE(Real(1e-4), Real(1e-2), Real(1), Real(1e2), Real(1e4));
  CAPTURE(s);
  const ShapePtr ball = make_sphere(s), box = make_box(2 * s, 2 * s, 2 * s), capsule = make_capsule(s / 2, 3 * s);
  const ShapePtr cylinder = make_cylinder(s, 2 * s), cone = make_cone(s, 2 * s);
  const Real tolerance = Real(2e-5) * s;
  CHECK(distance(*ball, vec3(3 * s, 4 * s, 0), *ball) == Approx(3 * s).margin(tolerance));
  CHECK(distance(*ball, vec3(4 * s, 5 * s, 0), *box) == Approx(4 * s).margin(tolerance));      // to an edge
  CHECK(distance(*ball, vec3(3 * s, 3 * s, 2 * s), *box) == Approx(2 * s).margin(tolerance));  // to a corner
  CHECK(distance(*box, vec3(3 * s, s / 2, 0), *box) == Approx(s).margin(tolerance));           // faces
  CHECK(distance(*box, vec3(3 * s, 4 * s, 4 * s), *box) == Approx(3 * s).margin(tolerance));   // corners
  CHECK(distance(*capsule, vec3(4 * s, s, 0), *capsule) == Approx(3 * s).margin(tolerance));   // side by side
  CHECK(distance(*capsule, vec3(0, 5 * s, 0), *capsule) == Approx(2 * s).margin(tolerance));   // end to end
  CHECK(distance(*cylinder, vec3(5 * s, 0, 0), *cylinder) == Approx(3 * s).margin(tolerance));
  CHECK(distance(*cylinder, vec3(4 * s, 4 * s, 0), *cylinder) == Approx(std::sqrt(Real(8)) * s).margin(tolerance));
  CHECK(distance(*ball, vec3(0, 4 * s, 0), *cone) == Approx(2 * s).margin(tolerance));  // above the tip
  // beside the cone: the slant x + y/2 = s/2 seen from (4 s, 2 s)
  CHECK(distance(*ball, vec3(4 * s, 2 * s, 0), *cone) ==
        Approx((Real(4.5) / std::sqrt(Real(1.25)) - 1) * s).margin(tolerance));
  const ClosestResult r = closest_points(*ball, {vec3(4 * s, 5 * s, 0), {}}, *box, {});
  CHECK((r.point_b - vec3(s, s, 0)).norm() < tolerance);
  CHECK((r.normal - vec3(Real(-0.6), Real(-0.8), 0)).norm() < 1e-4);
  CHECK(closest_points(*box, {vec3(s, 0, 0), {}}, *cylinder, {}).distance == 0);
}

TEST_CASE("huge against tiny", "[narrow][gjk]") {
  const ShapePtr huge = make_box(10000, 10000, 10000), tiny = make_box(Real(1e-3), Real(1e-3), Real(1e-3));
  const NarrowPhase generic("gjk");
  PairCache cache;
  Manifold m[kMaxManifolds];
  // tiny first: its frame keeps the precision
  REQUIRE(generic.collide(*tiny, {vec3(0, Real(0.5e-3) - Real(1e-5), 0), {}}, *huge, {vec3(0, -5000, 0), {}},
                          Real(1e-4), cache, m) == 1);
  CHECK((m[0].normal - vec3(0, -1, 0)).norm() < 1e-5);
  CHECK(m[0].count == 4);
}

TEST_CASE("flat ends stand on three points or more", "[narrow][manifold]") {
  const ShapePtr cylinder = make_cylinder(Real(0.5), 1), cone = make_cone(Real(0.5), 1), box = make_box(4, 1, 4);
  const Vec3 cloud[8] = {{-2, 0, -2},  {2, 0, -2},  {2, 0, 2},  {-2, 0, 2},
                         {-1, -1, -1}, {1, -1, -1}, {1, -1, 1}, {-1, -1, 1}};
  const ShapePtr hull = make_hull(cloud), plane = make_plane(vec3(0, 1, 0), 0);
  const Shape* ground[3] = {box.get(), hull.get(), plane.get()};
  const Shape* standing[2] = {cylinder.get(), cone.get()};
  const int which = GENERATE(0, 1, 2), top = GENERATE(0, 1);
  const Pose below{vec3(0, which == 0 ? Real(-0.5) : Real(0), 0), {}};
  Rng rng(4);
  for (int i = 0; i < 50; ++i) {
    const Real tilt = i % 2 ? Real(0) : rng.uniform(0, Real(2e-3));
    const Vec3 axis = vec3(rng.uniform(-1, 1), 0, rng.uniform(-1, 1));
    const Pose p{vec3(rng.uniform(-1, 1), Real(0.499), rng.uniform(-1, 1)),
                 from_axis_angle(axis, tilt) * from_axis_angle(vec3(0, 1, 0), rng.uniform(-3, 3))};
    const Hit hit = collide(*standing[top], p, *ground[which], below, Real(0.01));
    CAPTURE(which, top, i, tilt);
    REQUIRE(hit.count == 1);
    REQUIRE(hit.m[0].count >= 3);
    CHECK((hit.m[0].normal - vec3(0, -1, 0)).norm() < 3e-3);
    // the centre of mass is held: it lies between the points
    Real lo = kInfinity, hi = -kInfinity;
    for (int k = 0; k < hit.m[0].count; ++k) {
      const Vec3 d = hit.m[0].points[k].position - p.position;
      lo = std::min(lo, d[0]), hi = std::max(hi, d[0]);
      CHECK(hit.m[0].points[k].separation == Approx(-0.001).margin(2.5e-3));
    }
    CHECK(lo < Real(-0.3));
    CHECK(hi > Real(0.3));
  }
}

TEST_CASE("a lying capsule or cylinder touches in its two ends", "[narrow][manifold]") {
  const ShapePtr shapes[2] = {make_capsule(Real(0.5), 3), make_cylinder(Real(0.5), 2)};
  const ShapePtr box = make_box(6, 1, 6), plane = make_plane(vec3(0, 1, 0), 0);
  const int which = GENERATE(0, 1);
  const bool on_plane = GENERATE(false, true);
  const Pose lying{vec3(Real(0.2), Real(0.995), 0) - vec3(0, on_plane ? Real(0.5) : Real(0), 0),
                   from_axis_angle(vec3(0, 1, 0), Real(0.4)) * from_axis_angle(vec3(0, 0, 1), kPi / 2)};
  const Hit hit = collide(*shapes[which], lying, on_plane ? *plane : *box, {}, Real(0.01));
  REQUIRE(hit.count == 1);
  REQUIRE(hit.m[0].count == 2);
  CHECK((hit.m[0].normal - vec3(0, -1, 0)).norm() < 1e-3);
  CHECK(length(hit.m[0].points[0].position - hit.m[0].points[1].position) == Approx(2).margin(1e-3));
  for (int k = 0; k < 2; ++k) CHECK(hit.m[0].points[k].separation == Approx(-0.005).margin(1e-4));
}

TEST_CASE("parallel capsules touch in two points", "[narrow][manifold]") {
  const ShapePtr capsule = make_capsule(Real(0.5), 3);
  const Hit hit = collide(*capsule, {}, *capsule, {vec3(Real(0.99), 1, 0), {}}, Real(0.02));
  REQUIRE(hit.count == 1);
  REQUIRE(hit.m[0].count == 2);
  CHECK((hit.m[0].normal - vec3(1, 0, 0)).norm() < 1e-5);
  CHECK(std::abs(hit.m[0].points[0].position[1] - hit.m[0].points[1].position[1]) == Approx(1).margin(1e-4));
}

TEST_CASE("convex shapes on a plane: the lowest points", "[narrow][contract]") {
  const ShapePtr plane = make_plane(vec3(1, 2, Real(-0.5)), Real(0.3));
  const Vec3 n = vec3(1, 2, Real(-0.5)) / length(vec3(1, 2, Real(-0.5)));
  const Real d = Real(0.3) / length(vec3(1, 2, Real(-0.5)));
  Rng rng(6);
  for (const ShapeKind& kind : shape_kinds()) {
    for (const ShapePtr& s : kind.samples()) {
      if (!s->convex() || s->planar()) continue;
      CAPTURE(kind.name);
      const Real size = s->extent(Vec3::Zero()), margin = Real(0.02) * size;
      for (int i = 0; i < 50; ++i) {
        Pose p{Vec3::Zero(), random_rotation(rng)};
        const Vec3 low = to_world(p, s->support(rotate_inverse(p.rotation, -n)));
        const Real sink = size * rng.uniform(Real(-0.03), Real(0.1));
        p.position = n * (d - dot(n, low) + s->radius() - sink);
        const Hit hit = collide(*plane, {}, *s, p, margin);
        CHECK(hit.count == (-sink <= margin ? 1 : 0));
        if (!hit.count) continue;
        CHECK((hit.m[0].normal - n).norm() < 1e-5);
        CHECK(deepest(hit.m, 1) == Approx(-sink).margin(1e-4 * size));
        for (int k = 0; k < hit.m[0].count; ++k) {
          const ManifoldPoint& point = hit.m[0].points[k];
          CHECK(dot(n, point.position) - d == Approx(point.separation / 2).margin(1e-5 * (1 + size)));
          CHECK(point.separation <= margin);
        }
      }
    }
  }
}

TEST_CASE("sweeps stop at the first touch", "[narrow][cast]") {
  const ShapePtr ball = make_sphere(Real(0.5)), box = make_box(1, 1, 1), plane = make_plane(vec3(0, 1, 0), 0);
  const Vec3 v[4] = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
  const std::uint32_t t[6] = {0, 2, 1, 0, 3, 2};
  const ShapePtr mesh = make_mesh(v, t);
  CastHit hit;
  REQUIRE(shape_cast(*ball, {vec3(-5, 0, 0), {}}, vec3(10, 0, 0), *box, {}, hit));
  CHECK(hit.fraction == Approx(0.4).margin(1e-4));
  CHECK((hit.normal - vec3(-1, 0, 0)).norm() < 1e-3);
  CHECK((hit.point - vec3(Real(-0.5), 0, 0)).norm() < 1e-3);
  CHECK_FALSE(shape_cast(*ball, {vec3(-5, Real(1.01), 0), {}}, vec3(10, 0, 0), *box, {}, hit));
  CHECK_FALSE(shape_cast(*ball, {vec3(-5, 0, 0), {}}, vec3(Real(3.9), 0, 0), *box, {}, hit));
  CHECK_FALSE(shape_cast(*ball, {vec3(-5, 0, 0), {}}, vec3(-10, 0, 0), *box, {}, hit));
  for (const Shape* ground : {plane.get(), mesh.get()}) {
    REQUIRE(shape_cast(*box, {vec3(1, 3, 1), {}}, vec3(0, -5, 0), *ground, {}, hit));
    CHECK(hit.fraction == Approx(0.5).margin(1e-4));
    CHECK((hit.normal - vec3(0, 1, 0)).norm() < 1e-3);
    REQUIRE(shape_cast(*ball, {vec3(0, 200, 0), {}}, vec3(0, -1000, 0), *ground, {}, hit));
    CHECK(hit.fraction == Approx(0.1995).margin(1e-4));
  }
  REQUIRE(shape_cast(*ball, {vec3(0, Real(0.2), 0), {}}, vec3(0, 5, 0), *box, {}, hit));
  CHECK(hit.fraction == 0);
  const ShapePtr pair = make_compound({{box, {vec3(3, 0, 0), {}}}, {ball, {vec3(0, 3, 0), {}}}});
  REQUIRE(shape_cast(*ball, {vec3(-4, 3, 0), {}}, vec3(10, 0, 0), *pair, {}, hit));
  CHECK(hit.fraction == Approx(0.3).margin(1e-4));
}

TEST_CASE("overlap of any two kinds", "[narrow][query]") {
  const NarrowPhase narrow("auto");
  const ShapePtr ball = make_sphere(Real(0.5)), box = make_box(1, 1, 1), plane = make_plane(vec3(0, 1, 0), 0);
  const ShapePtr pair = make_compound({{box, {vec3(3, 0, 0), {}}}, {ball, {vec3(0, 3, 0), {}}}});
  CHECK(shapes_overlap(narrow, *ball, {vec3(Real(0.9), 0, 0), {}}, *box, {}));
  CHECK_FALSE(shapes_overlap(narrow, *ball, {vec3(Real(1.01), 0, 0), {}}, *box, {}));
  CHECK(shapes_overlap(narrow, *pair, {}, *ball, {vec3(Real(3.9), 0, 0), {}}));
  CHECK(shapes_overlap(narrow, *ball, {vec3(0, Real(3.9), 0), {}}, *pair, {}));
  CHECK_FALSE(shapes_overlap(narrow, *ball, {vec3(0, Real(4.1), 0), {}}, *pair, {}));
  CHECK(shapes_overlap(narrow, *plane, {}, *box, {vec3(0, Real(0.4), 0), {}}));
  CHECK_FALSE(shapes_overlap(narrow, *box, {vec3(0, Real(0.6), 0), {}}, *plane, {}));
}
