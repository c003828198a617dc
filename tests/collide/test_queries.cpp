// Rays, casts and overlaps against testing every shape, with filters, sensors and ties.
#include "collide/fake_owner.h"
#include "narrow/narrow_phase.h"
#include "support/catch.h"

using namespace feder;

namespace {

void fill(FakeWorld& w, Rng& rng) {
  for (int i = 0; i < 60; ++i) {
    const Real s = rng.uniform(Real(0.2), 1);
    const ShapePtr shape = i % 3 == 0 ? make_sphere(s) : make_box(s, 2 * s, s);
    w.add({{shape, {random_point(rng, Real(0.3)), {}}}},
          {random_point(rng, 6), from_axis_angle(random_point(rng, 1), rng.uniform(0, 6))},
          i % 5 ? ColliderMotion::dynamic : ColliderMotion::fixed);
  }
  for (std::uint32_t k = 0; k < w.c().size(); ++k) {
    w.c().group[k] = 1u << (k % 3);
    w.c().sensor[k] = k % 7 == 0;
  }
  w.add(make_plane(Vec3(0, 1, 0), -7), Vec3::Zero(), ColliderMotion::fixed);
}

bool visible(FakeWorld& w, std::uint32_t k, const QueryFilter& f) {
  if (w.c().sensor[k] && !f.sensors) return false;
  if (f.ignore && w.c().object[k] == f.ignore) return false;
  return (w.c().group[k] & f.mask) && (f.group & w.c().mask[k]);
}

QueryFilter some_filter(int n, FakeWorld& w) {
  QueryFilter f;
  if (n % 4 == 1) f.sensors = true;
  if (n % 4 == 2) f.mask = 5;
  if (n % 4 == 3) f.ignore = w.bodies[static_cast<std::size_t>(n) % w.bodies.size()].object;
  return f;
}

}  // namespace

TEST_CASE("rays find what testing every shape finds", "[collide][query]") {
  FakeWorld w;
  Rng rng(21);
  fill(w, rng);
  int hits = 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 origin = random_point(rng, 8), ray = random_point(rng, 12);
    const QueryFilter f = some_filter(n, w);
    Real nearest = 2;
    std::size_t count = 0;
    for (std::uint32_t k = 0; k < w.c().size(); ++k) {
      RayHit hit;
      if (!visible(w, k, f)) continue;
      if (!w.c().shape[k]->raycast(to_local(w.c().pose[k], origin), rotate_inverse(w.c().pose[k].rotation, ray), hit))
        continue;
      nearest = std::min(nearest, hit.fraction), ++count;
    }
    RaycastHit hit;
    std::vector<RaycastHit> all;
    CHECK(w.collide->raycast(origin, ray, f, hit) == (count > 0));
    w.collide->raycast_all(origin, ray, f, all);
    REQUIRE(all.size() == count);
    for (std::size_t i = 1; i < all.size(); ++i) CHECK(all[i - 1].fraction <= all[i].fraction);
    if (count == 0) continue;
    ++hits;
    CHECK(hit.fraction == nearest);
    CHECK(all[0].collider == hit.collider);
    CHECK(hit.object == w.c().object[hit.collider]);
    CHECK(length(hit.point - (origin + ray * hit.fraction)) < Real(1e-5));
    CHECK((hit.fraction == 0 || dot(hit.normal, ray) < Real(1e-4)));
  }
  CHECK(hits > 100);
}

TEST_CASE("equal hits fall to the lower collider", "[collide][query]") {
  FakeWorld w;
  for (int i = 0; i < 4; ++i) w.add(make_box(1, 1, 1), Vec3(5, 0, 0));
  RaycastHit hit;
  REQUIRE(w.collide->raycast(Vec3::Zero(), Vec3(10, 0, 0), {}, hit));
  CHECK(hit.collider == 0);
  CHECK(hit.fraction == Approx(0.45));
  CHECK(hit.normal[0] == Approx(-1));
}

TEST_CASE("overlaps and casts find what testing every shape finds", "[collide][query]") {
  FakeWorld w;
  Rng rng(22);
  fill(w, rng);
  const ShapePtr probe = make_box(1, 1, 2);
  int overlapping = 0, cast_hits = 0;
  for (int n = 0; n < 200; ++n) {
    const Pose pose{random_point(rng, 6), from_axis_angle(random_point(rng, 1), rng.uniform(0, 6))};
    const QueryFilter f = some_filter(n, w);
    const Vec3 motion = random_point(rng, 5);
    std::set<ObjectId> expected;
    Real nearest = 2;
    for (std::uint32_t k = 0; k < w.c().size(); ++k) {
      if (!visible(w, k, f)) continue;
      if (shapes_overlap(w.collide->narrow(), *probe, pose, *w.c().shape[k], w.c().pose[k]))
        expected.insert(w.c().object[k]);
      CastHit cast;
      if (shape_cast(*probe, pose, motion, *w.c().shape[k], w.c().pose[k], cast))
        nearest = std::min(nearest, cast.fraction);
    }
    std::vector<ObjectId> found;
    w.collide->overlap(*probe, pose, f, found);
    CHECK(found == std::vector<ObjectId>(expected.begin(), expected.end()));
    overlapping += found.empty() ? 0 : 1;
    RaycastHit hit;
    const bool any = w.collide->shape_cast(*probe, pose, motion, f, hit);
    CHECK(any == (nearest <= 1));
    if (!any) continue;
    CHECK(hit.fraction == nearest);
    ++cast_hits;
  }
  CHECK(overlapping > 20);
  CHECK(cast_hits > 20);
}
