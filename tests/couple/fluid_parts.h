// Worlds with fluid and things it meets, and how to weigh and count what is in them.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "contact/surface_contact.h"
#include "couple/cloth_rigid.h"
#include "couple/fluid_cloth.h"
#include "couple/fluid_rigid.h"
#include "couple/fluid_springs.h"
#include "couple/springs_rigid.h"
#include "couple/surface_rigid.h"
#include "feder/world.h"
#include "support/catch.h"

namespace feder {

inline Catalog mixed_catalog() {
  static const SystemDescriptor* const list[] = {
      &Collide::descriptor(),      &Rigid::descriptor(),          &Springs::descriptor(),
      &SpringsRigid::descriptor(), &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
      &Cloth::descriptor(),        &ClothRigid::descriptor(),     &Fluid::descriptor(),
      &FluidRigid::descriptor(),   &FluidCloth::descriptor(),     &FluidSprings::descriptor()};
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

// A square of n x n points in the xz plane.
inline NetDesc mat(std::uint32_t n, Real size, Real mass, Real stiffness) {
  NetDesc d;
  const Real cell = size / static_cast<Real>(n - 1);
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i)
      d.points.push_back(Vec3(cell * static_cast<Real>(i) - size / 2, 0, cell * static_cast<Real>(j) - size / 2));
  d.masses.assign(d.points.size(), mass / static_cast<Real>(d.points.size()));
  const auto spring = [&](std::uint32_t a, std::uint32_t b) {
    SpringDesc s;
    s.i = a, s.j = b, s.stiffness = stiffness, s.damping = Real(0.002) * stiffness;
    d.springs.push_back(s);
  };
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t k = j * n + i;
      if (i + 1 < n) spring(k, k + 1);
      if (j + 1 < n) spring(k, k + n);
      if (i + 1 == n || j + 1 == n) continue;
      spring(k, k + n + 1), spring(k + 1, k + n);
      d.faces.insert(d.faces.end(), {k, k + 1, k + n, k + 1, k + n + 1, k + n});
    }
  return d;
}

// A blob at 2 m/s hits an object that floats free in the middle: the sums of momentum and angular momentum stay, and at
// least `share` of the blob's momentum has passed to the object, by `momentum_of_it`. Impulses of steps that pass less
// than a thousandth of it are below the rounding of velocities that they change.
template <class F>
void check_blow(World& w, const std::string& solver, const char* mismatch, double share, F&& momentum_of_it) {
  Fluid& fluid = w.need<Fluid>();
  FluidDesc d;
  d.solver = solver;
  const ObjectId blob = fluid.add_fluid(d);
  fluid.fill(blob, block(4, 4, 4, d.spacing, Vec3(Real(0.13), Real(0.2), Real(0.06))), Vec3(Real(0.2), Real(-2), 0));
  const Vec3 p = vec(w.momentum().linear), l = vec(w.momentum().angular);
  double worst = 0, most = 0;
  Vec3 before = momentum_of_it();
  for (int k = 0; k < 60; ++k) {
    w.step();
    const Vec3 now = momentum_of_it();
    if (length(now - before) > Real(1e-3) * length(p)) worst = std::fmax(worst, residual(w, mismatch));
    most = std::fmax(most, static_cast<double>(length(now)));
    before = now;
  }
  CHECK(worst > 0);
  CAPTURE(solver, worst, most);
  CHECK(most > share * static_cast<double>(length(p)));
  CHECK(length(Vec3(vec(w.momentum().linear) - p)) < Real(1e-5) * length(p));
  CHECK(length(Vec3(vec(w.momentum().angular) - l)) < Real(1e-2) * length(l));
  CHECK(worst < 1e-4);
  CHECK(w.is_finite());
}

// A lone drop that slides along a sheet that is held, half thick above its middle: Coulomb's law slows it down.
inline void check_slide(World& w, Real half) {
  Fluid& fluid = w.need<Fluid>();
  FluidDesc d;
  d.friction = Real(0.3);
  const ObjectId id = fluid.add_fluid(d);
  fluid.fill(id, std::vector<Vec3>{Vec3(Real(-0.4), d.spacing / 2 + half, Real(0.013))}, Vec3(2, 0, 0));
  std::vector<Vec3> v;
  for (int k = 0; k < 18; ++k) w.step();
  fluid.velocities(id, v);
  const double still = 2 - 0.3 * 9.81 * 18 * static_cast<double>(w.desc().dt);
  CAPTURE(v[0][0], still);
  CHECK(static_cast<double>(v[0][0]) == Approx(still).margin(0.06));
}

}  // namespace feder
