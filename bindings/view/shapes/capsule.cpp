#include "view/tessellate.h"

namespace feder::view {

ShapeDrawing draw_capsule() {
  return {"capsule", [](const Shape& s) { return scaled_ball(s, reach(s, vec3(0, 1, 0), 1)); }};
}

}  // namespace feder::view
