// Signed distances of every kind of shape, against supports and rays. A new kind is enrolled by its line alone.
#include "direction.h"
#include "feder/sdf.h"
#include "support/catch.h"

using namespace feder;

namespace {

template <class Check>
void for_points(const Check& check) {
  const int kind = GENERATE(range(0, static_cast<int>(shape_kinds().size())));
  for (const ShapePtr& s : shape_kinds()[static_cast<std::size_t>(kind)].samples()) {
    Real size = s->extent(Vec3::Zero());
    if (!(size < kInfinity)) size = 2;
    Rng rng(static_cast<std::uint64_t>(kind) + 5);
    for (int i = 0; i < 300; ++i) {
      const Vec3 way = random_direction(rng, s->planar());
      const Real far = rng.uniform(0, Real(1.6));
      const Vec3 p = way * (size * far);
      Vec3 n = Vec3::Zero();
      const Real d = s->distance(p, 4 * size, n);
      CAPTURE(s->kind(), size, i, p[0], p[1], p[2], d, n[0], n[1], n[2]);
      check(*s, size, p, d, n, rng);
    }
  }
}

}  // namespace

TEST_CASE("the distance to a convex shape is the largest over its supporting planes", "[geom][contract]") {
  for_points([](const Shape& s, Real size, const Vec3& p, Real d, const Vec3& n, Rng& rng) {
    if (!s.convex()) return;
    const Real slack = Real(2e-5) * size;
    REQUIRE(length(n) == Approx(1).margin(1e-4));
    // two nearest features tie within rounding: the distance is exact, the normal to the root of that
    CHECK(dot(n, p - s.support(n)) - s.radius() == Approx(d).margin(2 * std::sqrt(kEpsilon) * size));
    for (int k = 0; k < 20; ++k) {
      const Vec3 u = random_direction(rng, s.planar());
      CHECK(dot(u, p - s.support(u)) - s.radius() <= d + slack);
    }
  });
}

namespace {

// Of a distance field: within two cells of where two surfaces are as near, with errors of .9 of the spacing.
bool between_surfaces(const Shape& s, const Vec3& p) {
  const auto report = sdf_report(s);
  if (!report) return false;
  Vec3 n, m;
  s.distance(p, kInfinity, n);
  for (int k = 0; k < 6; ++k) {
    Vec3 step = Vec3::Zero();
    step[k / 2] = (k % 2 ? 2 : -2) * report->spacing;
    s.distance(p + step, kInfinity, m);
    if (dot(n, m) < Real(0.8)) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("a ray along the distance meets the surface, and no shorter one does", "[geom][contract]") {
  for_points([](const Shape& s, Real size, const Vec3& p, Real d, const Vec3& n, Rng& rng) {
    RayHit hit;
    if (d < Real(sdf_report(s) ? 3e-3 : 1e-3) * size) return;  // a field: a tenth of a cell
    if (between_surfaces(s, p)) return;
    const auto report = sdf_report(s);  // the direction is good near the surface
    if (d < (report ? 3 * report->spacing
                    : 4 * size)) {  // within the limit; a ray at the very tip may slip past it: aim a little inwards
      const MassProperties m = s.mass(1);
      const Vec3 surface = p - n * d;
      const Real off = report ? Real(0.9) * report->spacing : Real(0);  // near its edges
      Vec3 ray = n * (Real(-1.01) * d - 2 * off);
      if (s.convex()) ray = surface + Real(0.02) * (m.center - surface) - p;
      REQUIRE(s.raycast(p, ray, hit));
      CHECK(hit.fraction * length(ray) == Approx(d).margin(Real(0.03) * size + off));
    }
    for (int k = 0; k < 20; ++k) CHECK_FALSE(s.raycast(p, random_direction(rng, s.planar()) * (Real(0.998) * d), hit));
  });
}

TEST_CASE("the sign of the distance says which side", "[geom][contract]") {
  for_points([](const Shape& s, Real size, const Vec3& p, Real d, const Vec3&, Rng&) {
    if (std::string(s.kind()) == "mesh") {
      CHECK(d >= 0);
      return;
    }
    if (std::abs(d) < Real(1e-4) * size) return;
    RayHit hit;
    CHECK(s.raycast(p, Vec3::Zero(), hit) == (d < 0));
  });
}
