// Depth of two outlines in the plane (internal to narrow).
#pragma once
#include "geom/polygon.h"
#include "narrow/gjk.h"

namespace feder {

// Of polygons whose cores overlap; in the frame of a.
Gap polygon_overlap(const ConvexPair& pair, const Polygon& a, const Polygon& b);

}  // namespace feder
