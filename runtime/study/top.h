// Euler's equations of a heavy rigid body about a fixed point, for references. Private to the module and its tests.
#pragma once
#include "study/reference.h"

namespace feder {

// Body axes are principal; the centre of mass lies on body axis `axis`; `weight` = m g times its distance, N m, pulls
// along -y of the world (0: free). State: w in body axes (0..2), q body to world as x y z w (3..6).
struct TopEquation {
  Wide inertia[3];
  Wide weight = 0;
  int axis = 1;
  void operator()(Wide t, const Wide* y, Wide* dy) const;
};

// R(q) e_axis.
void axis_of(const Wide* q, int axis, Wide (&out)[3]);

}  // namespace feder
