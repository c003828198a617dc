// Springs in the kernels' layout: eight points side by side, each with its springs one below the other. A spring
// appears twice, once at either end, so that each point gathers its own forces: no two lanes, slices or threads write
// the same point, and sums run in the order of the springs at any width. Plain structs only, since a file compiled with
// -mavx2 includes them.
#pragma once
#include "base/simd.h"

namespace feder {

// One spring of each of eight points. A lane without a spring has no stiffness.
struct SpringRow {
  Lane8 stiffness;         // N/m
  Lane8 rest_length;       // m
  unsigned other[kLanes];  // the point at the far end
};

struct SpringPass {
  const WideReal* position = nullptr;   // x y z _ by point, m
  const WideReal* velocity = nullptr;   // likewise, m/s; null: no spring damps
  const unsigned* row_begin = nullptr;  // by slice of eight points, one more than slices
  const SpringRow* rows = nullptr;
  const Lane8* damping = nullptr;  // by row, N s/m; null: no spring damps
  const Lane8* slack = nullptr;    // by row, 1: pulls only; null: none of them
  const Lane8* power = nullptr;    // by row, of the extension; null: all are linear
  Lane8x3* force = nullptr;        // by slice, added to, N
  unsigned first = 0, last = 0;    // slices
};

// Which springs are longer than their limit, eight to a byte.
struct SnapPass {
  const WideReal* position = nullptr;  // x y z _ by point
  const unsigned* i = nullptr;         // by spring
  const unsigned* j = nullptr;
  const WideReal* limit = nullptr;   // squared length, m^2
  unsigned char* snapped = nullptr;  // by group of eight springs
  unsigned count = 0;                // springs
  unsigned first = 0, last = 0;      // groups
};

struct SpringKernels {
  // Returns how many springs had their ends at one spot (each end counts).
  unsigned (*add_forces)(const SpringPass& pass);
  // Returns how many have snapped.
  unsigned (*find_snapped)(const SnapPass& pass);
};

extern const SpringKernels kSpringKernelsPlain, kSpringKernelsAvx2;

// Squared length below which a spring has no direction, m^2: square roots of smaller numbers lose their digits.
#ifdef FEDER_REAL_DOUBLE
inline constexpr WideReal kNoLength2 = 16 * __DBL_MIN__;
#else
inline constexpr WideReal kNoLength2 = 16 * __FLT_MIN__;
#endif

}  // namespace feder
