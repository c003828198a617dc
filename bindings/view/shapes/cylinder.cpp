#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_cylinder() {
  return {"cylinder", [](const Shape& s) { return scaled_frustum(s, [] { return frustum("cylinder", 1, 1); }); }};
}

}  // namespace feder::view
