#include <cmath>

#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry unit_disc() {
  Geometry g;
  g.kind = "disc";
  std::vector<Outline> outline;
  for (int i = 0; i < kRound; ++i) {
    const float a = kTurn * static_cast<float>(i) / kRound;
    const Float3 p{std::cos(a), std::sin(a), 0};
    outline.push_back({p, p});
  }
  prism(g, outline, 1);
  return g;
}

}  // namespace

ShapeDrawing draw_circle() {
  return {"circle", [](const Shape& s) {
            const auto r = static_cast<float>(s.radius());
            return Drawing{unit_disc, {r, r, kPrismDepth}};
          }};
}

}  // namespace feder::view
