// Soft body solver: from forces and tetrahedra to displacements in one solver substep. Knows no contacts. One file per
// solver, one feder_variant(soft <solver>) line. Contract, checked for every row by tests/soft:
//  - free fall is exact, momentum and angular momentum are kept, pinned points stay;
//  - a body in equilibrium has the strain of its material;
//  - no allocation after the first step, the same bits for any thread count.
#pragma once
#include "base/registry.h"
#include "feder/params.h"
#include "feder/plan.h"
#include "soft/tetrahedra.h"
#include "state/surface.h"

namespace feder {

// Lame's constants, and those of the stable neo-Hookean energy (Smith, de Goes and Kim, "Stable Neo-Hookean Flesh
// Simulation", TOG 2018, eq. 14), which agree with them for small strains:
//   Psi = mu'/2 (|F|^2 - 3) - mu'/2 log(|F|^2 + 1) + lambda'/2 (J - gamma)^2,  gamma = 1 + 3/4 mu'/lambda'
// Without the logarithm a tetrahedron that is squeezed to a point would stay there.
struct SoftMaterial {
  double mu = 0, lame = 0;                  // Pa
  double shear = 0, lambda = 0, gamma = 1;  // mu', lambda', Pa
  double bulk() const { return lame + mu * 2 / 3; }
};
SoftMaterial soft_material(double young, double poisson);

// View of a soft body for its solver in a step; indices from 0 within it.
struct SoftView {
  const SoftMesh* mesh = nullptr;
  std::uint32_t points = 0;   // the next one is the spare that empty lanes may point to
  std::uint64_t version = 0;  // changes with mesh and material
  SoftMaterial material;
  double density = 0;                  // kg/m^3
  Real damping = 0;                    // s
  const Vec3* position = nullptr;      // at the start of the step, m
  Row4* delta_position = nullptr;      // displacement since then, m; w: inverse mass
  Row4* before = nullptr;              // the same at the start of the solver substep
  Row4* velocity = nullptr;            // m/s; w: inverse mass
  const Vec3* acceleration = nullptr;  // of gravity, generators and scripts, m/s^2
  // Acceleration by contacts and attachments, as far as the last two solver substeps agree, m/s^2.
  const Vec3* steady_contact = nullptr;
};

// What a solver makes of a number of solver substeps.
struct SoftStiffness {
  double share = 1;  // of the stiffness that the body acts with
};

class SoftSolver {
 public:
  virtual ~SoftSolver() = default;
  // Solver substeps that a substep of h needs for the stiffness of the material, from mesh and material alone.
  virtual double wanted_substeps(const SoftView& soft, Real h) = 0;
  // Once per step, before the first substep; h: one solver substep.
  virtual SoftStiffness prepare(const SoftView& soft, Real h, StepContext& c) = 0;
  // One solver substep of h: writes `delta_position`, and `before`, from which velocities will be read after contacts
  // have corrected `delta_position`: with w 0 the start of the solver substep (velocity = difference/h), with w 1 its
  // end, `velocity` being written already (velocity += difference/h).
  virtual void advance(const SoftView& soft, Real h, StepContext& c) = 0;
  // Asserts that its elements are those of this mesh, unless the mesh is newer than they are.
  virtual void validate(const SoftView&) const {}
};

std::span<const Variant<SoftSolver>> soft_solvers();

}  // namespace feder
