#include "geom/polygon.h"

#include <cmath>

#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry tessellate_polygon(const Shape& shape) {
  const auto& polygon = static_cast<const Polygon&>(shape);
  const auto points = polygon.points(), normals = polygon.normals();
  const auto r = static_cast<float>(shape.radius());
  std::vector<Outline> outline;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2& before = normals[(i + normals.size() - 1) % normals.size()];
    const Vec2& after = normals[i];
    const float from = std::atan2(static_cast<float>(before[1]), static_cast<float>(before[0]));
    float turn = std::atan2(static_cast<float>(after[1]), static_cast<float>(after[0])) - from;
    if (turn < 0) turn += kTurn;
    const Float3 at{static_cast<float>(points[i][0]), static_cast<float>(points[i][1]), 0};
    const int steps = r > 0 ? std::max(1, static_cast<int>(std::ceil(turn / kTurn * kRound))) : 1;
    for (int k = 0; k <= steps; ++k) {
      const float a = from + turn * static_cast<float>(k) / static_cast<float>(steps);
      const Float3 n{std::cos(a), std::sin(a), 0};
      outline.push_back({at + r * n, n});
    }
  }
  Geometry g;
  g.kind = "polygon";
  prism(g, outline, kPrismDepth);
  return g;
}

}  // namespace

ShapeDrawing draw_polygon() {
  return {"polygon", [](const Shape& s) { return Drawing{.own = tessellate_polygon(s)}; }};
}

}  // namespace feder::view
