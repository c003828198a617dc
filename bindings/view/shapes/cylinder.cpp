#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry unit_cylinder() {
  Geometry g = frustum(1, 1);
  g.kind = "cylinder";
  return g;
}

}  // namespace

ShapeDrawing draw_cylinder() {
  return {"cylinder", [](const Shape& s) {
            const float radius = reach(s, vec3(1, -1, 0), 0);
            return Drawing{unit_cylinder, {radius, 2 * reach(s, vec3(0, 1, 0), 1), radius}};
          }};
}

}  // namespace feder::view
