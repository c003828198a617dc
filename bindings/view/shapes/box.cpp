#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry unit_box() {
  Geometry g;
  g.kind = "box";
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-0.5f, 0.5f}) {
      const auto corner = [&](float u, float v) {
        Float3 p;
        p[axis] = sign, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        return p;
      };
      std::vector<Float3> loop = {corner(-0.5f, -0.5f), corner(0.5f, -0.5f), corner(0.5f, 0.5f), corner(-0.5f, 0.5f)};
      if (sign < 0) std::swap(loop[1], loop[3]);
      Float3 n;
      n[axis] = 2 * sign;
      face(g, loop, n);
    }
  return g;
}

}  // namespace

ShapeDrawing draw_box() {
  return {"box", [](const Shape& s) { return Drawing{unit_box, 2 * to_float3(s.support(vec3(1, 1, 1)))}; }};
}

}  // namespace feder::view
