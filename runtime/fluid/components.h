// Connected components of a fluid, for the CFL number: which particles can meet within a substep, at which speed.
#pragma once
#include "fluid/pool.h"

namespace feder {

// Largest speed in the frames of a fluid's components, and the largest g H of a column in one.
struct FlowScales {
  Real speed2 = 0;  // squared, m^2/s^2
  Real head = 0;    // m^2/s^2
};

// From positions and velocities alone, so that a restored fluid gets the same. Sorts `grid` and `order` of the pool and
// writes `isolated`; the particles keep their order. The boundary is that at the start of the substep of c.h seconds.
// tests/fluid/test_lone_drop.cpp.
FlowScales flow_scales(FluidPool& p, const Boundary& boundary, const StepContext& c);

// The fluid as one column: of particles with neighbours, as isolated ones do not weigh on it.
struct ColumnScales {
  Real speed2 = 0;  // largest of all particles, squared, m^2/s^2
  Real pace = 0;    // typical speed, m/s: squared mean of the roots, so that few fast ones hardly count
  Real height = 0;  // twice the mean height above the lowest particle, m; 0 where there is none, or no gravity
  Real head = 0;    // g H, and what holds it together from all sides, m^2/s^2
  std::uint32_t count = 0;
  Aabb box;
};
ColumnScales column_scales(const FluidPool& p, const StepContext& c);

// Largest speed that counts for the CFL number, m/s: of the column's particles (in the frames of their components,
// where they move by more than `travel` m in a step), and of bodies whose boxes meet it.
Real speed_near(FluidPool& p, const ColumnScales& column, const Boundary& boundary, Real travel, const StepContext& c);

}  // namespace feder
