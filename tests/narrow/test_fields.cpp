// Contacts of distance fields against what they stand for: depth and normal of balls, boxes and planes on fields of
// spheres and boxes against the same pair without fields; what a resting pair costs in queries.
#include "base/rng.h"
#include "feder/sdf.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

ShapePtr field_of(const ShapePtr& shape, Real spacing) {
  SdfDesc d;
  d.shape = shape, d.spacing = spacing;
  return make_sdf(d);
}

struct Solids {
  ShapePtr shape, field;
};

Real least(const Manifold* m, int count) {
  Real depth = kInfinity;
  for (int n = 0; n < count; ++n)
    for (int k = 0; k < m[n].count; ++k) depth = std::min(depth, m[n].points[k].separation);
  return depth;
}

}  // namespace

TEST_CASE("contacts of fields are those of the solids that they hold", "[narrow][sdf]") {
  const NarrowPhase narrow("auto");
  const Real h = Real(0.04);
  const Solids ball{make_sphere(Real(0.5)), field_of(make_sphere(Real(0.5)), h)};
  const Solids box{make_box(1, Real(0.8), Real(0.6)), field_of(make_box(1, Real(0.8), Real(0.6)), h)};
  Rng rng(9);
  int met = 0;
  for (int i = 0; i < 600; ++i) {
    const Solids& one = i % 2 ? ball : box;
    const bool other_ball = i % 3 == 0;
    const Solids& other = other_ball ? ball : box;
    const bool both = i % 5 == 0;  // field and field, else field and convex
    const Pose at_one{Vec3::Zero(), random_rotation(rng, false)};
    const Vec3 way = random_direction(rng, false);
    Pose at_other{Vec3::Zero(), random_rotation(rng, false)};
    const Real touch = -gap_along(*one.shape, at_one, *other.shape, at_other, way);
    at_other.position = way * (touch + rng.uniform(Real(-0.03), Real(0.015)));
    const ClosestResult exact = closest_points(*one.shape, at_one, *other.shape, at_other);
    PairCache cache;
    Manifold truth[kMaxManifolds], found[kMaxManifolds], back[kMaxManifolds];
    const Real margin = Real(0.02);
    const int expected = narrow.collide(*one.shape, at_one, *other.shape, at_other, margin, cache, truth);
    const Shape& second = both ? *other.field : *other.shape;
    const int count = narrow.collide(*one.field, at_one, second, at_other, margin, cache, found);
    const int turned = narrow.collide(second, at_other, *one.field, at_one, margin, cache, back);
    const Real depth = expected ? least(truth, expected) : exact.distance;
    CAPTURE(i, one.shape->kind(), other.shape->kind(), both, depth, count);
    // edges and corners of a field are rounded by up to .9 of its spacing, those of two by both
    const bool smooth = one.shape == ball.shape && (!both || other_ball);
    // smooth ones lie 1.1 h^2/(4 q) inside
    const Real slack = (both ? 2 : 1) * (smooth ? Real(1.2) * h * h / 2 : Real(0.9) * h);
    if (depth < margin - slack) {
      ++met;
      REQUIRE(count > 0);
    }
    if (depth > margin + slack) CHECK(count == 0);
    if (count == 0) continue;
    CHECK(double(least(found, count)) == Approx(double(depth)).margin(double(slack)));
    for (int n = 0; n < count; ++n) {
      CHECK(double(length(found[n].normal)) == Approx(1).margin(1e-4));
      CHECK((found[n].count >= 1 && found[n].count <= kMaxManifoldPoints));
    }
    if (smooth) CHECK(double(dot(found[0].normal, truth[0].normal)) > 0.999);
    REQUIRE(turned > 0);
    CHECK(double(least(back, turned)) == Approx(double(least(found, count))).margin(double(slack)));
    // nothing keeps its state
    Manifold again[kMaxManifolds];
    REQUIRE(narrow.collide(*one.field, at_one, second, at_other, margin, cache, again) == count);
    for (int n = 0; n < count; ++n) CHECK((again[n].normal == found[n].normal && again[n].count == found[n].count));
  }
  CHECK(met > 120);
}

TEST_CASE("a field rests on a plane and on triangles by the corners of its foot", "[narrow][sdf]") {
  const NarrowPhase narrow("auto");
  const ShapePtr field = field_of(make_box(1, Real(0.6), 1), Real(0.05));
  const Vec3 v[4] = {vec3(-3, 0, -3), vec3(3, 0, -3), vec3(3, 0, 3), vec3(-3, 0, 3)};
  const std::uint32_t t[6] = {0, 2, 1, 0, 3, 2};
  for (const ShapePtr& floor : {make_plane(vec3(0, 1, 0), 0), make_mesh(v, t), make_box(8, 2, 8)}) {
    CAPTURE(floor->kind());
    const Pose below{vec3(0, floor->convex() ? Real(-1) : Real(0), 0), {}};
    PairCache cache;
    Manifold m[kMaxManifolds];
    const Pose at{vec3(Real(0.2), Real(0.295), 0), from_axis_angle(vec3(0, 1, 0), Real(0.4))};
    REQUIRE(narrow.collide(*field, at, *floor, below, Real(0.02), cache, m) == 1);
    CHECK(m[0].count == 4);
    CHECK(double(m[0].normal[1]) == Approx(-1).margin(1e-3));
    Vec3 lo = m[0].points[0].position, hi = lo;
    int down = 0;  // the fourth may be on the rim, half a cell higher
    for (int k = 0; k < 4; ++k) {
      down += std::abs(m[0].points[k].separation + Real(0.005)) < Real(0.002);
      lo = lo.cwiseMin(m[0].points[k].position), hi = hi.cwiseMax(m[0].points[k].position);
    }
    CHECK(down >= 3);
    CHECK((hi - lo)[0] > Real(0.65));  // the foot is 1 m, turned
    CHECK((hi - lo)[2] > Real(0.65));
  }
}

TEST_CASE("sweeps stop at fields and fields stop at what they meet", "[narrow][sdf]") {
  const ShapePtr field = field_of(make_box(1, 1, Real(0.2)), Real(0.03)), ball = make_sphere(Real(0.1));
  CastHit hit;
  REQUIRE(shape_cast(*ball, {vec3(Real(0.1), 0, 3), {}}, vec3(0, 0, -6), *field, {}, hit));
  CHECK(double(hit.fraction) == Approx((3 - 0.2) / 6).margin(1e-3));
  CHECK(double(hit.normal[2]) == Approx(1).margin(1e-2));
  CHECK_FALSE(shape_cast(*ball, {vec3(2, 0, 3), {}}, vec3(0, 0, -6), *field, {}, hit));
}
