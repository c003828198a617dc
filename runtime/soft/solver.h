// Soft body solver: from forces and tetrahedra to displacements in one solver substep. Knows no contacts. One file per
// solver, one feder_variant(soft <solver>) line. Contract, checked for every row by tests/soft:
//  - free fall is exact, momentum and angular momentum are kept, pinned points stay;
//  - a body in equilibrium has the strain of its material;
//  - no allocation after the first step, the same bits for any thread count.
#pragma once
#include <cmath>
#include <string>

#include "base/registry.h"
#include "feder/params.h"
#include "feder/plan.h"
#include "soft/elasticity.h"
#include "soft/tetrahedra.h"
#include "state/surface.h"

namespace feder {

// View of a soft body for its solver in a step; indices from 0 within it.
struct SoftView {
  const SoftMesh* mesh = nullptr;
  std::uint32_t points = 0;   // the next one is the spare that empty lanes may point to
  std::uint64_t version = 0;  // changes with mesh and material
  std::uint64_t shape = 0;    // changes where shapes at rest flow
  SoftMaterial material;
  const ElasticLaw* law = nullptr;     // of elasticity
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
  // Does it have this law? Else such a body is an error.
  virtual bool takes(const ElasticLaw& law) const = 0;
  // Do shapes at rest flow with it? Else plastic bodies are an error.
  virtual bool flows() const { return true; }
  // Once per step, before the first substep; h: one solver substep.
  virtual SoftStiffness prepare(const SoftView& soft, Real h, StepContext& c) = 0;
  // One solver substep of h: writes `delta_position`, and `before`, from which velocities will be read after contacts
  // have corrected `delta_position`: with w 0 the start of the solver substep (velocity = difference/h), with w 1 its
  // end, `velocity` being written already (velocity += difference/h).
  virtual void advance(const SoftView& soft, Real h, StepContext& c) = 0;
  // Once per substep, after the last solver substep and what contacts did: takes strain rate out of `velocity`.
  virtual void damp(const SoftView&, Real /*h*/, StepContext&) {}
  // What its iterations did not reach in this step, and the cure: "" when they reached their tolerance. Once per step,
  // after the last substep.
  virtual std::string shortfall() const { return ""; }
  // What of the material it does not have: "" when it has all of it.
  virtual std::string limits(const SoftView&) { return ""; }
  // J, above that at rest, with the points there, where its energy is its own; else NaN: it is that of the law.
  virtual double elastic_energy(const SoftView&, const Array<Vec3>&) { return NAN; }
  // By how many solver substeps the velocity it works with leads the true one in free fall: x after n solver substeps h
  // is x0 + v0 n h + g (n h)^2/2 + lead g n h^2. Read and written velocities are set right by it.
  virtual Real lead() const { return Real(0.5); }
  // State that it keeps between steps, for snapshots.
  virtual void save(Writer&) const {}
  virtual void load(Reader&) {}
  // Asserts that its elements are those of this mesh, unless the mesh is newer than they are.
  virtual void validate(const SoftView&) const {}
};

std::span<const Variant<SoftSolver>> soft_solvers();

}  // namespace feder
