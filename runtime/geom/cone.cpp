// Cone along y: the base at -height / 2, the tip at height / 2.
#include "geom/frustum.h"
#include "geom/sizes.h"

namespace feder {

ShapeKind geom_cone() {
  return {"cone",
          "(radius, height)",
          "along y, tip up, origin at half its height",
          {.convex = true},
          {{"radius", ShapeArgumentType::size}, {"height", ShapeArgumentType::size}},
          [](const ShapeInput& in) -> ShapePtr {
            const Real radius = positive_size(in.size(0), "cone", "radius");
            return make_frustum("cone", radius, Real(0), positive_size(in.size(1), "cone", "height"));
          },
          [] {
            return std::vector<ShapePtr>{make_cone(1, 2), make_cone(1, Real(0.3)), make_cone(Real(0.01), Real(0.03))};
          }};
}

}  // namespace feder
