// Cylinder along y.
#include "geom/frustum.h"
#include "geom/sizes.h"

namespace feder {

ShapePtr make_cylinder(Real radius, Real height) {
  positive_size(radius, "cylinder", "radius");
  positive_size(height, "cylinder", "height");
  return std::make_shared<Frustum>("cylinder", radius, radius, height);
}

ShapeKind geom_cylinder() {
  return {"cylinder", [] {
            return std::vector<ShapePtr>{make_cylinder(1, 2), make_cylinder(1, Real(0.1)),
                                         make_cylinder(Real(0.01), Real(0.05))};
          }};
}

}  // namespace feder
