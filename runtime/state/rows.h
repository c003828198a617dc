// Constraint rows: the contract between joints (who fill them) and solvers (who read them). A block is up to six
// rows between two solver bodies that are solved together; a row with bounds that can become active must stand alone.
#pragma once
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

// One scalar constraint C(x) between solver body a and solver body b.
//   dC/dt = linear . (v_b - v_a) + angular_b . w_b + angular_a . w_a
struct Row {
  Vec3 linear = Vec3::Zero();
  Vec3 angular_a = Vec3::Zero();
  Vec3 angular_b = Vec3::Zero();
  Real value = 0;  // C, m or rad (0 for a pure motor)
  Real bend = 0;   // m/s: change of C in the coming substep beyond h dC/dt by the rotation of the bodies, over h
  Real speed = 0;  // wanted dC/dt, m/s or rad/s (motors)
  Real lower = -kInfinity;  // bounds of the force (N) or torque (N m) along the Jacobian
  Real upper = kInfinity;
  Real hertz = 0;  // 0: as stiff as the solver can make it; else a spring of that frequency
  Real damping_ratio = 1;
  bool velocity_only = false;  // motor or friction: `value` is ignored
};

struct RowBlock {
  std::uint32_t index_a = 0, index_b = 0;  // solver indices (0 = world)
  std::uint32_t first = 0;                 // in Rows::rows
  std::uint16_t count = 0;                 // rows solved together, at most 6
  std::uint32_t joint = kNone;
  std::uint32_t first_impulse = 0;  // where the block's impulses stay between steps (joint's array)
};

}  // namespace feder
