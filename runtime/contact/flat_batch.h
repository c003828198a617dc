// Triangles of a flat rest shape, eight to a batch, and the kernels that measure how they move (flat_parts.h). Plain
// structs only: included by the file that is compiled with -mavx2. Private to the module.
#pragma once
#include "base/simd.h"

namespace feder {

// Empty lanes repeat a triangle, without its area.
struct FlatBatch {
  unsigned v[3][kLanes];
  Lane8 inverse[4];  // of the edges at rest in the plane, by rows, 1/m
  Lane8 area;        // m^2
};

// Columns of a gradient at the start of the motion, and what the motion adds.
struct FlatGradients {
  Lane8x3 start[2], change[2];
};

struct FlatPass {
  const FlatBatch* batches;
  FlatGradients* gradients;  // as many
  unsigned count;
  const WideReal *at, *way;  // rows of four: positions and displacements, m
  WideReal sum[2][3];        // of the gradients in the middle of the motion, times areas
  WideReal frame[2][3];      // orthonormal columns
  WideReal least, largest;   // of the symmetric parts in the frame, and of |F|^2, at both ends of the motion
};

struct FlatKernels {
  void (*gradients)(FlatPass&);  // into `gradients` and `sum`
  void (*test)(FlatPass&);       // into `least` and `largest`
};

extern const FlatKernels kFlatKernelsPlain, kFlatKernelsAvx2;

}  // namespace feder
