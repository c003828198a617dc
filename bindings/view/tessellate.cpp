#include "view/tessellate.h"

#include <cmath>
#include <tuple>

namespace feder::view {
namespace {

constexpr int kRings = 8;  // from equator to pole

Float3 unit(Float3 a) {
  const float n = length(a);
  return n > 0 ? (1 / n) * a : Float3{0, 1, 0};
}

std::uint32_t add(Geometry& g, Float3 p, Float3 n, float edge = 0, float side = 0) {
  g.vertices.push_back({p, n, side, edge});
  return static_cast<std::uint32_t>(g.vertices.size() - 1);
}
void triangle(Geometry& g, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  g.indices.insert(g.indices.end(), {a, b, c});
}

}  // namespace

void face(Geometry& g, const std::vector<Float3>& loop, Float3 normal) {
  Float3 middle{0, 0, 0};
  for (Float3 p : loop) middle = middle + (1 / static_cast<float>(loop.size())) * p;
  const std::uint32_t center = add(g, middle, normal);
  for (Float3 p : loop) add(g, p, normal, 1);
  const auto n = static_cast<std::uint32_t>(loop.size());
  for (std::uint32_t i = 0; i < n; ++i) triangle(g, center, center + 1 + i, center + 1 + (i + 1) % n);
}

void prism(Geometry& g, const std::vector<Outline>& outline, float depth) {
  const float h = depth / 2;
  std::vector<Float3> front, back;
  for (const Outline& o : outline) front.push_back({o.at.x, o.at.y, h});
  for (std::size_t i = outline.size(); i-- > 0;) back.push_back({outline[i].at.x, outline[i].at.y, -h});
  face(g, front, {0, 0, 1});
  face(g, back, {0, 0, -1});
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Outline &a = outline[i], &b = outline[(i + 1) % outline.size()];
    const std::uint32_t v = add(g, {a.at.x, a.at.y, -h}, a.normal);
    add(g, {b.at.x, b.at.y, -h}, b.normal);
    add(g, {b.at.x, b.at.y, h}, b.normal);
    add(g, {a.at.x, a.at.y, h}, a.normal);
    triangle(g, v, v + 1, v + 2), triangle(g, v, v + 2, v + 3);
  }
}

Geometry frustum(const char* kind, float bottom, float top) {
  Geometry g;
  g.kind = kind;
  std::vector<Float3> low, high;
  const float slope = bottom - top;
  for (int i = 0; i <= kRound; ++i) {
    const float a = kTurn * static_cast<float>(i) / kRound, half = kTurn * (static_cast<float>(i) + 0.5f) / kRound;
    const float c = std::cos(a), s = -std::sin(a);
    const Float3 n = unit({c, slope, s}), tip = unit({std::cos(half), slope, -std::sin(half)});
    add(g, {bottom * c, -0.5f, bottom * s}, n), add(g, {top * c, 0.5f, top * s}, top > 0 ? n : tip);
    if (i == kRound) break;
    low.insert(low.begin(), {bottom * c, -0.5f, bottom * s});
    high.push_back({top * c, 0.5f, top * s});
    const auto v = static_cast<std::uint32_t>(2 * i);
    triangle(g, v, v + 2, v + 1);
    if (top > 0) triangle(g, v + 1, v + 2, v + 3);
  }
  face(g, low, {0, -1, 0});
  if (top > 0) face(g, high, {0, 1, 0});
  return g;
}

Geometry unit_ball() {
  Geometry g;
  g.kind = "ball";
  // rings from the lower pole up; the equator twice, once for each half
  for (int half = 0; half < 2; ++half)
    for (int ring = 0; ring <= kRings; ++ring) {
      const float latitude = kTurn / 4 * (static_cast<float>(ring) / kRings - (half == 0 ? 1 : 0));
      for (int i = 0; i <= kRound; ++i) {
        const float a = kTurn * static_cast<float>(i) / kRound;
        const Float3 p{std::cos(latitude) * std::cos(a), std::sin(latitude), -std::cos(latitude) * std::sin(a)};
        add(g, p, p, 0, half == 0 ? -1.0f : 1.0f);
      }
    }
  constexpr std::uint32_t row = kRound + 1;
  for (std::uint32_t ring = 0; ring + 1 < 2 * (kRings + 1); ++ring)
    for (std::uint32_t i = 0; i < kRound; ++i) {
      const std::uint32_t v = ring * row + i;
      if (ring > 0) triangle(g, v, v + 1, v + row + 1);
      if (ring < 2 * kRings) triangle(g, v, v + row + 1, v + row);
    }
  return g;
}

Geometry tessellate_mesh(const Shape& shape) {
  Geometry g;
  g.kind = shape.kind();
  g.two_sided = true;
  auto walk = std::tie(shape, g);
  const auto visit = [](void* context, std::uint32_t index) {
    auto& [from, to] = *static_cast<decltype(walk)*>(context);
    const Triangle t = from.triangle(index);
    const Float3 a = to_float3(t.a), b = to_float3(t.b), c = to_float3(t.c), n = unit(cross(b - a, c - a));
    const std::uint32_t v = add(to, a, n);
    add(to, b, n), add(to, c, n);
    triangle(to, v, v + 1, v + 2);
  };
  shape.triangles_in(Aabb::everything(), visit, &walk);
  return g;
}

Geometry tessellate_convex(const Shape& shape) {
  Geometry g = unit_ball();
  g.kind = "convex";
  for (Vertex& v : g.vertices) {
    v.position = to_float3(shape.support(to_vec3(v.normal))) + static_cast<float>(shape.radius()) * v.normal;
    v.side = 0;
  }
  return g;
}

Drawing scaled_ball(const Shape& shape, float stretch) {
  const auto r = static_cast<float>(shape.radius());
  return {unit_ball, {r, r, r}, stretch};
}

Drawing scaled_frustum(const Shape& shape, Geometry (*unit)()) {
  const float radius = reach(shape, vec3(1, -1, 0), 0);
  return {unit, {radius, 2 * reach(shape, vec3(0, 1, 0), 1), radius}};
}

}  // namespace feder::view
