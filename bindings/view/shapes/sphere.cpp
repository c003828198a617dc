#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_sphere() {
  return {"sphere", [](const Shape& s) { return scaled_ball(s, 0); }};
}

}  // namespace feder::view
