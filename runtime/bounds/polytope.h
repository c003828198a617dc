// Volume and edges of what lies within half-spaces: polygons in their planes, cut by all the others.
#pragma once
#include <vector>

#include "base/double3.h"
#include "bounds/edges.h"

namespace feder {

struct HalfSpace {
  Double3 normal;  // outwards, of any length
  double offset;   // normal . x <= offset
};
// m^3; `size`: no corner is farther from the origin than that.
double volume_within(const std::vector<HalfSpace>& planes, double size);
// The same; false when the visitor wants no more.
bool edges_within(const std::vector<HalfSpace>& planes, double size, EdgeVisitor visit);

}  // namespace feder
