// From triangles to distances at the corners of a grid.
#pragma once
#include <vector>

#include "feder/sdf.h"
#include "geom/distance_field.h"
#include "geom/triangle_field.h"

namespace feder {

struct Acquired {
  std::vector<float> values;  // m, x fastest
  double most_turns = 0;      // largest winding number asked for; above 1: parts of the mesh lie in each other
};
// Without sign: the band and the sweeps alone.
std::vector<float> rasterised(const TriangleField& triangles, const FieldLayout& layout);
Acquired acquire(const TriangleField& triangles, const FieldLayout& layout, SdfAcquire how);

}  // namespace feder
