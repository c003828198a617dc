// Distances and winding numbers over the hierarchy against all triangles, one by one.
#include "base/rng.h"
#include "geom/closest.h"
#include "geom/triangle_field.h"
#include "geom/winding.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A ball of bumps: rings of quadrangles between two poles, counterclockwise from outside.
std::vector<Vec3> bumpy_ball(int rings) {
  const auto at = [&](int i, int j) {
    const double a = 3.14159265358979 * i / rings, b = 2 * 3.14159265358979 * j / rings;
    const double r = 1 + 0.2 * std::sin(5 * a) * std::sin(4 * b), around = i % rings ? r * std::sin(a) : 0;
    return vec3(Real(around * std::cos(b)), Real(r * std::cos(a)), Real(around * std::sin(b)));
  };
  std::vector<Vec3> corners;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < rings; ++j) {
      const Vec3 a = at(i, j), b = at(i, (j + 1) % rings), c = at(i + 1, j), d = at(i + 1, (j + 1) % rings);
      corners.insert(corners.end(), {a, b, c, b, d, c});
    }
  return corners;
}

}  // namespace

TEST_CASE("nearest triangles and winding numbers are those of the sum over all", "[geom][sdf]") {
  const std::vector<Vec3> corners = bumpy_ball(24);
  const TriangleField field(corners);
  REQUIRE(field.count() == corners.size() / 3);
  CHECK(field.volume() > 3.5);
  CHECK(field.open_edges() == 0);
  Rng rng(4);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = vec3(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-2, 2));
    Real least = kInfinity;
    for (std::size_t t = 0; t < corners.size(); t += 3) {
      const Vec3 d = p - closest_on_triangle(p, corners[t], corners[t + 1], corners[t + 2]);
      least = std::min(least, dot(d, d));
    }
    std::uint32_t nearest;
    CHECK(field.nearest(p, kInfinity, nearest) == least);
    CHECK(field.distance_squared(p, nearest) == least);
    CHECK(field.nearest(p, std::sqrt(least) * Real(0.999), nearest) > least * Real(0.99));
    CHECK(nearest == kNone);
    worst = std::max(worst, std::abs(field.winding(p) - winding_number(corners, p)));
  }
  CHECK(worst < 0.02);
}

TEST_CASE("holes have the area that would close them", "[geom][sdf]") {
  const Vec3 v[8] = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 2, 0), vec3(0, 2, 0),
                     vec3(0, 0, 3), vec3(1, 0, 3), vec3(1, 2, 3), vec3(0, 2, 3)};
  const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 4, 7, 3}, {1, 2, 6, 5}};
  std::vector<Vec3> corners;
  for (const auto& f : faces)
    for (const int k : {0, 1, 2, 0, 2, 3}) corners.push_back(v[f[k]]);
  CHECK(TriangleField(corners).volume() == Approx(6));
  CHECK(TriangleField(corners).area() == Approx(22));
  CHECK(TriangleField(corners).open_area() == 0);
  corners.resize(corners.size() - 6);  // without one of 2 x 3
  const TriangleField open(corners);
  CHECK(open.open_edges() == 4);
  CHECK(open.open_area() == Approx(6));
}
