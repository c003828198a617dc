#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry unit_cone() {
  Geometry g = frustum(1, 0);
  g.kind = "cone";
  return g;
}

}  // namespace

ShapeDrawing draw_cone() {
  return {"cone", [](const Shape& s) {
            const float radius = reach(s, vec3(1, -1, 0), 0);
            return Drawing{unit_cone, {radius, 2 * reach(s, vec3(0, 1, 0), 1), radius}};
          }};
}

}  // namespace feder::view
