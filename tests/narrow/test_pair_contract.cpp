// The contract of narrow/narrow_phase.h for every pair of convex kinds, against the support functions alone.
#include "base/rng.h"
#include "feder/error.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Case {
  const Shape* a;
  const Shape* b;
  Pose pa, pb;
  Real size, margin;
};

Case random_case(Rng& rng, const Shape& a, const Shape& b) {
  const bool planar = a.planar();
  Case c{&a, &b, {}, {}, 0, 0};
  const Real ea = a.extent(Vec3::Zero()), eb = b.extent(Vec3::Zero());
  c.size = std::max(ea, eb);
  c.margin = Real(0.02) * std::min(ea, eb);
  c.pa = {random_direction(rng, planar) * ea, random_rotation(rng, planar)};
  c.pb.rotation = random_rotation(rng, planar);
  const Vec3 d = random_direction(rng, planar);
  c.pb.position = c.pa.position;
  // from the first touch along d, a little further in or out, sometimes deep
  const Real touch = -gap_along(a, c.pa, b, c.pb, d);
  c.pb.position +=
      d * (rng.next() % 3 == 0 ? touch * rng.uniform(Real(0.2), 1) : touch + c.margin * rng.uniform(-2, 1));
  return c;
}

// The largest gap over sampled directions around n and everywhere.
Real sampled_gap(Rng& rng, const Case& c, const Vec3& n) {
  Real best = -kInfinity;
  for (int i = 0; i < 300; ++i) {
    const Vec3 d = random_direction(rng, c.a->planar());
    best = std::max(best, gap_along(*c.a, c.pa, *c.b, c.pb, d));
    const Vec3 near = n + d * rng.uniform(0, Real(0.2));
    best = std::max(best, gap_along(*c.a, c.pa, *c.b, c.pb, near / length(near)));
  }
  return best;
}

void check_case(const NarrowPhase& narrow, const Case& c, Rng& rng) {
  const Real tolerance =
      Real(2e-3) * std::min(c.a->extent(Vec3::Zero()), c.b->extent(Vec3::Zero())) + Real(2e-5) * c.size;
  PairCache cache, fresh;
  Manifold m[kMaxManifolds], back[kMaxManifolds], again[kMaxManifolds];
  const int count = narrow.collide(*c.a, c.pa, *c.b, c.pb, c.margin, cache, m);
  const int reversed = narrow.collide(*c.b, c.pb, *c.a, c.pa, c.margin, fresh, back);
  const int cached = narrow.collide(*c.a, c.pa, *c.b, c.pb, c.margin, cache, again);
  const ClosestResult closest = closest_points(*c.a, c.pa, *c.b, c.pb);
  CAPTURE(c.pa.position.transpose(), c.pb.position.transpose(), closest.distance, c.margin, tolerance);
  CHECK(count == cached);
  if (count == 0) {
    // apart by more than the margin: by GJK, and for overlaps that GJK calls 0 by some direction
    if (closest.distance < c.margin - tolerance) CHECK(sampled_gap(rng, c, closest.normal) > c.margin - tolerance);
    return;
  }
  REQUIRE(count == 1);
  const Manifold& r = m[0];
  const Real depth = deepest(m, count);
  CAPTURE(r.normal.transpose(), depth, r.count);
  REQUIRE(r.count >= 1);
  CHECK(length(r.normal) == Approx(1).margin(1e-5));
  for (int k = 0; k < r.count; ++k) CHECK(r.points[k].separation <= c.margin);

  CHECK(depth == Approx(deepest(again, cached)).margin(tolerance / 10));
  CHECK((r.normal - again[0].normal).norm() < 1e-2);
  if (depth < c.margin - tolerance) {
    REQUIRE(reversed == 1);
    CHECK(depth == Approx(deepest(back, reversed)).margin(tolerance));
  }
  // the normal tells the truth about the gap along it, and no direction tells of a larger one
  const Real along = gap_along(*c.a, c.pa, *c.b, c.pb, r.normal);
  CHECK(along == Approx(depth).margin(tolerance));
  CHECK(sampled_gap(rng, c, r.normal) <= std::max(depth, closest.distance) + tolerance);
  if (closest.distance > 0) CHECK(depth <= closest.distance + tolerance);
  // points lie between the surfaces: inside both supports along the normal
  for (int k = 0; k < r.count; ++k) {
    const Vec3 sa = to_world(c.pa, c.a->support(rotate_inverse(c.pa.rotation, r.normal)));
    CHECK(dot(r.normal, r.points[k].position - sa) - c.a->radius() <= std::max(c.margin, Real(0)) + tolerance);
  }
  if (depth < 0) {
    Case apart = c;
    apart.pb.position -= r.normal * depth;
    PairCache none;
    const int left = narrow.collide(*c.a, c.pa, *c.b, apart.pb, 0, none, back);
    if (left) CHECK(deepest(back, left) > -tolerance);
  }
}

}  // namespace

TEST_CASE("pairs of convex shapes keep the narrow-phase contract", "[narrow][contract]") {
  const int kinds = static_cast<int>(shape_kinds().size());
  const int i = GENERATE_COPY(range(0, kinds));
  const int method = GENERATE(range(-2, static_cast<int>(narrow_methods().size())));
  const char* algorithm = method == -2 ? "auto" : method == -1 ? "gjk" : narrow_methods()[std::size_t(method)].name;
  const NarrowPhase narrow(algorithm);
  Rng rng(static_cast<std::uint64_t>(i) + 1);
  for (int j = i; j < kinds; ++j) {
    if (!shape_kinds()[i].traits.convex || !shape_kinds()[j].traits.convex) continue;
    for (const ShapePtr& a : shape_kinds()[i].samples()) {
      for (const ShapePtr& b : shape_kinds()[j].samples()) {
        if (a->planar() != b->planar()) continue;
        CAPTURE(algorithm, a->kind(), b->kind(), a->extent(Vec3::Zero()), b->extent(Vec3::Zero()));
        for (int trial = 0; trial < 30; ++trial) check_case(narrow, random_case(rng, *a, *b), rng);
      }
    }
  }
}

TEST_CASE("a pair that a build has no test for is known", "[narrow]") {
  // planes and meshes among themselves never touch, nor do 2D sections and solids; of all others there is a test
  CHECK(NarrowPhase("auto").complete());
  CHECK(NarrowPhase("gjk").complete());
  for (const NarrowMethod& method : narrow_methods()) CHECK(NarrowPhase(method.name).complete());
  std::vector<PairRow> rows;
  for (const PairRow& row : pair_tests())
    if (std::string(row.kind_a) != "convex" || std::string(row.kind_b) != "convex") rows.push_back(row);
  const NarrowPhase lean("auto", rows);
  CHECK_FALSE(lean.complete());
  const ShapePtr cone = make_cone(1, 1), box = make_box(1, 1, 1), plane = make_plane(Vec3(0, 1, 0), 0);
  CHECK(lean.lacks(*cone, *box));
  CHECK(lean.lacks(*box, *cone));
  CHECK_FALSE(lean.lacks(*box, *box));  // it has box_box
  CHECK_FALSE(lean.lacks(*cone, *plane));
  CHECK_FALSE(lean.lacks(*plane, *plane));
  CHECK_FALSE(lean.lacks(*cone, *make_circle(1)));
  CHECK_FALSE(NarrowPhase("auto", std::span<const PairRow>()).complete());
}

TEST_CASE("unknown narrow phase is a scene mistake", "[narrow]") { CHECK_THROWS_AS(NarrowPhase("sat"), SceneError); }
