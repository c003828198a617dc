// Every registered kind of shape as triangles: inside its bounds and filling them, closed, facing outwards, with the
// volume of its mass.
#include <cmath>

#include "support/catch.h"
#include "view/geometry.h"
#include "view/solids.h"

using namespace feder;
using namespace feder::view;

namespace {

Instance placed(const Fitted& f, const Pose& pose) {
  Instance i;
  i.position = to_float3(pose.position), i.scale = f.scale;
  i.rotation[0] = static_cast<float>(pose.rotation.x), i.rotation[1] = static_cast<float>(pose.rotation.y);
  i.rotation[2] = static_cast<float>(pose.rotation.z), i.rotation[3] = static_cast<float>(pose.rotation.w);
  i.stretch = f.stretch;
  return i;
}

struct D3 {
  double x, y, z;
};
D3 d3(Float3 p) { return {p.x, p.y, p.z}; }
D3 minus(D3 a, D3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
D3 crossed(D3 a, D3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
double dotted(D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Calls f(a, b, c, vertex of a) for each triangle.
template <class F>
void each_triangle(const Solid& s, F&& f) {
  for (std::size_t t = 0; t + 2 < s.indices.size(); t += 3)
    f(d3(s.vertices[s.indices[t]].position), d3(s.vertices[s.indices[t + 1]].position),
      d3(s.vertices[s.indices[t + 2]].position), s.vertices[s.indices[t]]);
}

ShapePtr sample(std::size_t kind, std::size_t number) {
  const auto samples = shape_kinds()[kind].samples();
  return number < samples.size() ? samples[number] : nullptr;
}

}  // namespace

TEST_CASE("triangles fill the bounds of their shape", "[view][contract]") {
  const auto kind = static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(shape_kinds().size()))));
  const auto number = static_cast<std::size_t>(GENERATE(0, 1, 2));
  const int turned = GENERATE(0, 1);
  const ShapePtr shape = sample(kind, number);
  if (!shape) return;
  CAPTURE(shape->kind(), number, turned);
  GeometryCache cache;
  const Fitted f = cache.fit(shape);
  if (f.geometry == kNone) return;  // planes are grounds, compounds are their parts
  Pose pose;
  pose.position = vec3(1, -2, Real(0.5));
  if (turned) pose.rotation = from_axis_angle(shape->planar() ? vec3(0, 0, 1) : vec3(1, 2, 3), Real(0.7));
  const Solid s = solid(placed(f, pose), *cache.geometries()[f.geometry]);
  Bounds drawn;
  for (const MeshVertex& v : s.vertices) drawn.include(v.position);
  const Aabb box = shape->bounds(pose);
  for (int k = 0; k < (shape->planar() ? 2 : 3); ++k) {
    const float size = static_cast<float>(box.hi[k] - box.lo[k]), lo = static_cast<float>(box.lo[k]),
                hi = static_cast<float>(box.hi[k]);
    CAPTURE(k, lo, drawn.low[k], hi, drawn.high[k]);
    // circles of 32 segments reach at least cos(pi / 32) = 0.995 of the radius
    CHECK(drawn.low[k] >= lo - 1e-4f * size - 1e-5f);
    CHECK(drawn.high[k] <= hi + 1e-4f * size + 1e-5f);
    CHECK(drawn.low[k] <= lo + 0.01f * size + 1e-5f);
    CHECK(drawn.high[k] >= hi - 0.01f * size - 1e-5f);
  }
}

TEST_CASE("triangles of solid shapes enclose the volume of the mass and face outwards", "[view][contract]") {
  const auto kind = static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(shape_kinds().size()))));
  const auto number = static_cast<std::size_t>(GENERATE(0, 1, 2));
  const ShapePtr shape = sample(kind, number);
  if (!shape || !shape->convex()) return;
  CAPTURE(shape->kind(), number);
  GeometryCache cache;
  const Fitted f = cache.fit(shape);
  REQUIRE(f.geometry != kNone);
  const Solid s = solid(placed(f, {}), *cache.geometries()[f.geometry]);
  double volume = 0;
  int wrong = 0;
  each_triangle(s, [&](D3 a, D3 b, D3 c, const MeshVertex& v) {
    volume += dotted(a, crossed(b, c)) / 6;
    const D3 n = crossed(minus(b, a), minus(c, a));
    wrong += dotted(n, d3(v.normal)) < 0;
    CHECK(std::abs(dotted(d3(v.normal), d3(v.normal)) - 1) < 1e-4);
  });
  CHECK(wrong == 0);
  // 2D masses are per square metre; drawn as prisms
  const double depth = shape->planar() ? static_cast<double>(kPrismDepth) : 1;
  const double expected = static_cast<double>(shape->mass(1).mass) * depth;
  CHECK(volume == Approx(expected).epsilon(0.035));  // a ball of 32 x 16 faces has 2 % less
}

TEST_CASE("surfaces of solid shapes are closed", "[view][contract]") {
  const auto kind = static_cast<std::size_t>(GENERATE(range(0, static_cast<int>(shape_kinds().size()))));
  const ShapePtr shape = sample(kind, 0);
  if (!shape || !shape->convex()) return;
  CAPTURE(shape->kind());
  GeometryCache cache;
  const Fitted f = cache.fit(shape);
  const Solid s = solid(placed(f, {}), *cache.geometries()[f.geometry]);
  // the vector areas of a closed surface add up to zero
  D3 sum{0, 0, 0};
  double area = 0;
  each_triangle(s, [&](D3 a, D3 b, D3 c, const MeshVertex&) {
    const D3 n = crossed(minus(b, a), minus(c, a));
    sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
    area += std::sqrt(dotted(n, n));
  });
  CHECK(std::sqrt(dotted(sum, sum)) < 1e-4 * area);
}

TEST_CASE("boxes of every size share one geometry", "[view]") {
  GeometryCache cache;
  const auto a = cache.fit(make_box(1, 2, 3)).geometry, b = cache.fit(make_box(Real(0.1), 5, 1)).geometry;
  CHECK(a == b);
  CHECK(cache.fit(make_sphere(1)).geometry == cache.fit(make_capsule(Real(0.2), 1)).geometry);
  CHECK(cache.geometries().size() == 2);
}
