// Load of joints that can break, noted by solvers after each substep: the largest one counts, since a blow is over
// within a substep.
#pragma once
#include <algorithm>
#include <span>

#include "rigid/solver.h"
#include "state/rows.h"

namespace feder {

inline void note_force(SolverJoint& joint, const Vec3& impulse, Real h) {
  joint.peak_force = std::max(joint.peak_force, length(impulse) / h);
}

// The same from rows. `blocks`: those of the joint.
inline void note_force(SolverJoint& joint, std::span<const Row> rows, std::span<const RowBlock> blocks, Real h) {
  Vec3 sum = Vec3::Zero();
  for (const RowBlock& block : blocks)
    for (std::uint32_t k = 0; k < block.count; ++k)
      sum += rows[block.first + k].linear * joint.impulse[block.first_impulse + k];
  note_force(joint, sum, h);
}

}  // namespace feder
