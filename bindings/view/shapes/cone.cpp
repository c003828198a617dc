#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_cone() {
  return {"cone", [](const Shape& s) { return scaled_frustum(s, [] { return frustum("cone", 1, 0); }); }};
}

}  // namespace feder::view
