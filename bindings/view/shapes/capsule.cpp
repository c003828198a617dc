#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_capsule() {
  return {"capsule", [](const Shape& s) {
            const auto r = static_cast<float>(s.radius());
            return Drawing{unit_ball, {r, r, r}, reach(s, vec3(0, 1, 0), 1)};
          }};
}

}  // namespace feder::view
