// How close each solver must come to the closed forms, in one place. A solver without a row gets the last one.
// Numbers are relative unless a unit is given.
#pragma once
#include <cstring>

namespace feder {

struct ClosedTolerance {
  const char* solver;
  double impact;         // speeds after a single impact
  double apex;           // heights of the first bounces
  double friction;       // distances and speeds under sliding friction
  double rolling;        // speeds of rolling bodies
  double pendulum;       // period
  double spring;         // m and m/s, against the recurrence
  double stack_impulse;  // contact impulses of a stack at rest
  double stack_drift;    // m sideways in 10 s awake, and m per contact downwards
  double heavy_sink;     // m, of 100 kg on 1 kg
  double joint_error;    // m, of joints under ordinary load
  double angular;        // kg m^2/s lost in 10000 steps of tumbling joints (soft_step pulls joints back in position)
};

inline const ClosedTolerance& closed_tolerance(const char* solver) {
  static const ClosedTolerance table[] = {
      {"soft_step", 1e-3, 0.03, 0.01, 0.01, 0.005, 2e-4, 0.02, 2e-3, 0.02, 2e-3, 0.15},
      {"impulse", 1e-3, 0.01, 0.01, 0.01, 0.005, 2e-4, 0.02, 1e-3, 0.002, 2e-3, 0.05},
      {"", 5e-3, 0.05, 0.02, 0.02, 0.01, 1e-3, 0.03, 5e-3, 0.05, 5e-3, 0.2},
  };
  for (const ClosedTolerance& row : table)
    if (row.solver[0] == 0 || std::strcmp(row.solver, solver) == 0) return row;
  return table[0];
}

}  // namespace feder
