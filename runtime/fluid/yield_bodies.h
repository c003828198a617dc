// How bodies yield to an explicit fluid while it presses on them: linearly implicit.
#pragma once
#include "feder/plan.h"
#include "fluid/pool.h"

namespace feder {

// Changes the impulses of the contacts with bodies that the fluid moves, and the accelerations of their particles in
// `move`, to those that are left when the bodies yield to them. `h`: s, of the kick; `lead`: s, for which a change of a
// body's velocity counts for its pose where forces are found next. tests/fluid/test_wcsph.cpp.
void yield_bodies(FluidPool& p, const Boundary& boundary, Real h, Real lead, StepContext& c);

}  // namespace feder
