#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_sphere() {
  return {"sphere", [](const Shape& s) {
            const auto r = static_cast<float>(s.radius());
            return Drawing{unit_ball, {r, r, r}};
          }};
}

}  // namespace feder::view
