// Frustum: a circle at the bottom, one at the top (radius 0: a tip), straight sides. Cylinder and cone are two of its
// kinds.
#pragma once
#include "feder/shape.h"

namespace feder {

// `kind`: whose row makes it. Radii and height in m.
ShapePtr make_frustum(const char* kind, Real bottom, Real top, Real height);

}  // namespace feder
