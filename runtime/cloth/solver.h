// Cloth solver: from forces and elements to displacements in one solver substep. Knows no contacts.
// One file per solver, one feder_variant(cloth <solver>) line. Contract, checked for every row by
// tests/cloth/test_closed_forms.cpp and test_system.cpp:
//  - free fall is exact, momentum is kept, pinned vertices stay;
//  - a hanging sheet takes the stretch of its material;
//  - no allocation after the first step, the same bits for any thread count.
#pragma once
#include <string>

#include "base/registry.h"
#include "cloth/batch.h"
#include "cloth/mesh.h"
#include "feder/params.h"
#include "feder/plan.h"
#include "state/surface.h"

namespace feder {

// View of a cloth for its solver in a step; indices from 0 within the cloth, hidden vertices included.
struct ClothView {
  const ClothMesh* mesh = nullptr;
  std::uint32_t points = 0;                   // visible
  std::uint32_t total = 0;                    // with hidden ones; the last is the spare that empty lanes may point to
  std::uint64_t version = 0;                  // changes with the mesh
  std::uint64_t rests = 0;                    // changes with rest lengths and angles too, where `flows`
  bool flows = false;                         // plastic
  Real lacking = 1;                           // solver substeps that it would need, by those it gets
  bool taut = false;                          // tension holds it: closed under pressure, or in a frame too large
  Real damping = 0;                           // s
  Real max_strain = kInfinity;                // of links
  Real tie_limit = kInfinity;                 // over rest, at which ties and long links act
  std::span<TieBatch> ties;                   // to fixed anchors
  std::span<const std::uint32_t> tie_layers;  // ends of the layers of `ties`
  bool crowded = false;                       // surfaces of its group are in contact in this substep
  const Vec3* position = nullptr;             // at the start of the step, m
  const Vec3* rest = nullptr;                 // unstrained, m
  Row4* delta_position = nullptr;             // displacement since then, m; w: inverse mass
  Row4* before = nullptr;                     // the same at the start of the solver substep
  Row4* velocity = nullptr;                   // m/s; w: inverse mass
  const Vec3* acceleration = nullptr;         // of gravity, wind and scripts, m/s^2
  const Real* mass = nullptr;                 // kg
};

class ClothSolver {
 public:
  virtual ~ClothSolver() = default;
  // Once per step, before the first substep.
  virtual void prepare(const ClothView& cloth, StepContext& c) = 0;
  // One solver substep of h from time t: writes `delta_position`, and `before`, from which velocities will be read
  // after contacts have corrected `delta_position`: with w 0 the start of the solver substep (velocity = difference/h),
  // with w 1 its end, `velocity` being written already (velocity += difference/h).
  virtual void advance(const ClothView& cloth, double t, Real h, StepContext& c) = 0;
  // Once per substep, after the last solver substep: takes strain rate out of `velocity`.
  virtual void damp(const ClothView& cloth, Real h, StepContext& c) = 0;
  // Solver substeps that a substep of h needs for the stability or accuracy of this solver; 1 when any number does.
  // From the rest shape and the pins alone, so that a restored cloth gets the same answer.
  virtual double wanted_substeps(const ClothView& cloth, Real h) const = 0;
  // By how many solver substeps the velocity it works with leads the true one in free fall: x after n solver substeps h
  // is x0 + v0 n h + g (n h)^2/2 + lead g n h^2. Read and written velocities are set right by it. After prepare.
  virtual Real lead(Real /*h*/) const { return Real(0.5); }
  // s: longer damping acts as this one in a substep of h. After prepare().
  virtual double longest_damping(Real) const { return double(kInfinity); }
  // State that it keeps between steps, for snapshots.
  virtual void save(Writer&) const {}
  virtual void load(Reader&) {}
  // What its iterations did not reach in this step, and the cure: "" when they reached their tolerance. Once per step,
  // after the last substep.
  virtual std::string shortfall() const { return ""; }
  // Asserts that its elements are those of this cloth's mesh, unless the mesh is newer than they are.
  virtual void validate(const ClothView&) const {}
  virtual Real relaxation() const { return 1; }         // of contact corrections
  virtual bool sheds_strain() const { return true; }    // the stretch law of step.cpp applies
  virtual bool reaches() const { return false; }        // has long links, see long_links.h
  virtual bool converges() const { return false; }      // the law for loads alone does: it carries its own weight
  virtual bool carries_bodies() const { return true; }  // what hangs from a vertex counts as mass of it, see ties.cpp
  virtual double least_cap() const { return 1; }        // solver substeps that `max_substeps` cannot forbid
  virtual double substeps_beyond(double cap) const {
    return cap;
  }  // solver substeps it takes where it wants more than the cap
  virtual const char* beyond_cap() const { return "stretches or bends more than its stiffness says"; }
};

std::span<const Variant<ClothSolver>> cloth_solvers();

}  // namespace feder
