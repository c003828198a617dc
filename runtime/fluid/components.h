// Connected components of a fluid, for the CFL number: which particles can meet within a substep, and at which speed.
#pragma once
#include "fluid/pool.h"

namespace feder {

// What one fluid moves at, and the largest g H of a column in it.
struct FlowScales {
  Real speed2 = 0;  // squared, m^2/s^2
  Real head = 0;    // m^2/s^2
};

// Of positions and velocities alone, so that a restored fluid gets the same. Sorts `grid` and `order` of the pool and
// writes `apart`; the particles stay where they are. Walls as they start the substep of c.h seconds.
// tests/fluid/test_lone_drop.cpp.
FlowScales flow_scales(FluidPool& p, const Boundary& boundary, const StepContext& c);

}  // namespace feder
