// Points eight at a time: the farthest along a direction, and the bounds of all under a rotation. Plain structs only,
// since a file compiled with -mavx2 includes them.
// Contract, checked by tests/geom/test_points_wide.cpp: both builds give the bits of the plain loop over the points;
// of equally far points the first is the answer.
#pragma once
#include "base/simd.h"

namespace feder {

// `groups`: the points in order, eight to a group; what is left of the last group repeats the first point.
struct PointKernel {
  // Index of the point p with the largest x p.x + y p.y + z p.z.
  unsigned (*farthest)(const Lane8x3* groups, unsigned count, WideReal x, WideReal y, WideReal z);
  // lo and hi, x y z each, of the points rotated by `rotation` (row after row).
  void (*bounds)(const Lane8x3* groups, unsigned count, const WideReal* rotation, WideReal* lo, WideReal* hi);
};
extern const PointKernel kPointsPlain;
extern const PointKernel kPointsAvx2;

}  // namespace feder
