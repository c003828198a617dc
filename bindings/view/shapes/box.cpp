#include "view/tessellate.h"

namespace feder::view {
namespace {

Geometry unit_box() {
  Geometry g;
  g.kind = "box";
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-0.5f, 0.5f}) {
      const auto corner = [&](float u, float v) {
        float p[3];
        p[axis] = sign, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        return P{p[0], p[1], p[2]};
      };
      std::vector<P> loop = {corner(-0.5f, -0.5f), corner(0.5f, -0.5f), corner(0.5f, 0.5f), corner(-0.5f, 0.5f)};
      if (sign < 0) std::swap(loop[1], loop[3]);
      P n{0, 0, 0};
      (axis == 0 ? n.x : axis == 1 ? n.y : n.z) = 2 * sign;
      face(g, loop, n);
    }
  return g;
}

}  // namespace

ShapeDrawing draw_box() {
  return {"box", [](const Shape& s) {
            const Vec3 corner = s.support(vec3(1, 1, 1));
            return Drawing{unit_box, 2 * point(corner)};
          }};
}

}  // namespace feder::view
