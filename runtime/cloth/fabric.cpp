// Woven fabric: stretch stiffness along the warp and along the weft. A sheet's cell with rows r_x, r_z (force per width
// and strain) and both diagonals k = s |d|^2/(2 area) is an orthotropic plane: C11 = r_x + s a, C22 = r_z + s/a, C12 =
// C66 = s, where a is the square of the cell's aspect (Absi and Prager 1975 derive lattices like it; s = `shear`).
// Young's moduli E1 = C11 - s^2/C22 and E2 = C22 - s^2/C11 are to be `warp` and `weft`: C22 = C11 E2/E1, and C11 is the
// positive root of C11^2 - E1 C11 - s^2 E1/E2 = 0. Rows cannot push: shear is bounded by what leaves r_x, r_z >= 0. At
// an angle the modulus is that of this plane: 1/E(45) = (S11 + S22 + 2 S12 + S66)/4 with S = C^-1
// (tests/cloth/test_fabric.cpp). A mesh has the threads' stiffness in its edges, by the angle to the warp.
#include <cmath>

#include "cloth/mesh.h"

namespace feder {

RowStiffness row_stiffness(const ClothStiffness& k, double aspect) {
  const double e1 = double(k.along()), e2 = double(k.across()), s = double(k.shear), a = aspect * aspect;
  FEDER_ASSERT(e1 > 0 && e2 > 0 && !(s < 0) && a > 0);
  const double c11 = 0.5 * (e1 + std::sqrt(e1 * e1 + 4 * s * s * e1 / e2)), c22 = c11 * e2 / e1;
  return {static_cast<Real>(c11 - s * a), static_cast<Real>(c22 - s / a)};
}

Real thread_stiffness(const ClothStiffness& k, const Vec3& edge) {
  const Vec3 axis(k.axis[0], k.axis[1], k.axis[2]);
  const Real along = dot(edge, axis) * dot(edge, axis) / dot(edge, edge);
  return k.across() + (k.along() - k.across()) * std::fmin(along, Real(1));
}

}  // namespace feder
