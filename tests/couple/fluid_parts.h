// Worlds with fluid and things it meets, and how to weigh and count what is in them.
#pragma once
#include <string>
#include <vector>

#include "couple/cloth_rigid.h"
#include "couple/fluid_cloth.h"
#include "couple/fluid_rigid.h"
#include "couple/fluid_springs.h"
#include "couple/springs_rigid.h"
#include "world/world.h"

namespace feder {

inline Catalog mixed_catalog() {
  static const SystemDescriptor* const list[] = {
      &Collide::descriptor(), &Rigid::descriptor(),      &Springs::descriptor(),    &SpringsRigid::descriptor(),
      &Cloth::descriptor(),   &ClothRigid::descriptor(), &Fluid::descriptor(),      &FluidRigid::descriptor(),
      &FluidCloth::descriptor(), &FluidSprings::descriptor()};
  return list;
}

inline Vec3 vec(const double (&m)[3]) {
  return Vec3(static_cast<Real>(m[0]), static_cast<Real>(m[1]), static_cast<Real>(m[2]));
}

inline double residual(World& w, const std::string& name) {
  for (const Residual& r : w.residuals())
    if (r.name == name) return r.value;
  return -1;
}

// A block of fluid of nx x ny x nz particles about `middle`.
inline std::vector<Vec3> block(int nx, int ny, int nz, Real spacing, const Vec3& middle) {
  std::vector<Vec3> x;
  for (int j = 0; j < ny; ++j)
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i)
        x.push_back(middle + spacing * Vec3(static_cast<Real>(i) - Real(0.5) * static_cast<Real>(nx - 1),
                                            static_cast<Real>(j) - Real(0.5) * static_cast<Real>(ny - 1),
                                            static_cast<Real>(k) - Real(0.5) * static_cast<Real>(nz - 1)));
  return x;
}

inline ClothDesc square(std::uint32_t n, Real size, bool pinned) {
  ClothDesc d;
  d.size[0] = d.size[1] = size;
  d.nx = d.ny = n;
  d.self_collision = false;
  if (pinned) d.pin_names = {"top", "bottom", "left", "right"};
  return d;
}

}  // namespace feder
