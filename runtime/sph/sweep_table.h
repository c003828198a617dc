// Input of the sums over neighbours, and the table of these functions of one kernel. Plain data: included by files
// compiled twice.
#pragma once
#include "base/simd.h"

namespace feder {

struct SweepInput {
  const WideReal* points = nullptr;     // x, y, z (m) and a weight w per particle; the one after the last lies far away
  const WideReal* velocity = nullptr;   // four numbers likewise, m/s
  const unsigned* neighbors = nullptr;  // `stride` per particle
  const unsigned* rounded = nullptr;    // number in use, in whole lanes
  unsigned stride = 0;
  WideReal inv_support = 0;  // 1/m
  WideReal soft = 0;         // m^2, keeps 1/r^2 finite
  WideReal damping = 0;      // of push_damped
};

// Sums over the neighbours j of the particles i in [first, last); x = x_i - x_j, g = slope(u). Four numbers per
// particle where the output is called out4.
struct Sweeps {
  void (*values)(const SweepInput&, unsigned first, unsigned last, WideReal* out);  // value(u)
  // g x, value(u); and (g u)^2
  void (*slopes)(const SweepInput&, unsigned first, unsigned last, WideReal* out4, WideReal* squares);
  void (*push)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);         // (w_i + w_j) g x
  void (*push_damped)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);  // the same, with damping
  // (w_i + w_j) g y, with y = y_i - y_j for other positions y, given instead of the velocities
  void (*push_from)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);
  // g x . (v_i - v_j), positive where they approach
  void (*growth)(const SweepInput&, unsigned first, unsigned last, WideReal* out);
  void (*cohere)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);   // cohesion(u) x / u
  void (*viscous)(const SweepInput&, unsigned first, unsigned last, WideReal* out4);  // see Kernel::radial_viscosity
};

}  // namespace feder
