// Cone along y: the base at -height / 2, the tip at height / 2.
#include "geom/frustum.h"
#include "geom/sizes.h"

namespace feder {

ShapePtr make_cone(Real radius, Real height) {
  positive_size(radius, "cone", "radius");
  positive_size(height, "cone", "height");
  return std::make_shared<Frustum>("cone", radius, Real(0), height);
}

ShapeKind geom_cone() {
  return {"cone", [] {
            return std::vector<ShapePtr>{make_cone(1, 2), make_cone(1, Real(0.3)), make_cone(Real(0.01), Real(0.03))};
          }};
}

}  // namespace feder
