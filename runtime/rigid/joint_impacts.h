// Impacts on jointed bodies within a substep, at their poses now: contacts see slender bodies, and rotations since the
// step began, otherwise (contact_batch.h), and solved in turn with joints the two would drive each other on.
#pragma once
#include <span>

#include "rigid/contact_group.h"
#include "rigid/solver.h"

namespace feder {

// Bodies as joints feel them. Two inertias, in turn, would drive each other on.
struct StruckBodies {
  const SolverInput& input;
  std::span<const Real> share;  // of their inverse inertia that joints use, by solver index; uneven ones know theirs
};

// A contact point that strikes.
struct PointImpact {
  ContactGroup::Place at;
  Vec3 normal, arm_a, arm_b;       // a to b; from the centres of mass, m
  std::uint32_t index_a, index_b;  // solver indices
  Real mass;                       // effective along the normal, kg
  Real friction;                   // coefficient
  Real impulse, rubbed;            // of this strike: along the normal, and across it in all, N s
};

// Points that the kernel `mark` has found. In scratch memory.
std::span<PointImpact> list_impacts(const ContactGroup& contacts, const StruckBodies& in, StepContext& c);

// Stops the points, in `rounds` of Gauss-Seidel, with Coulomb friction: each impulse takes energy.
void strike(std::span<PointImpact> impacts, int rounds, ContactGroup& contacts, const StruckBodies& in);

}  // namespace feder
