// Cylinder along y.
#include "geom/frustum.h"
#include "geom/sizes.h"

namespace feder {

ShapeKind geom_cylinder() {
  return {"cylinder",
          "(radius, height)",
          "along y",
          {.convex = true},
          {{"radius", ShapeArgumentType::size}, {"height", ShapeArgumentType::size}},
          [](const ShapeInput& in) -> ShapePtr {
            const Real radius = positive_size(in.size(0), "cylinder", "radius");
            return make_frustum("cylinder", radius, radius, positive_size(in.size(1), "cylinder", "height"));
          },
          [] {
            return std::vector<ShapePtr>{make_cylinder(1, 2), make_cylinder(1, Real(0.1)),
                                         make_cylinder(Real(0.01), Real(0.05))};
          }};
}

}  // namespace feder
