// Width of convex shapes.
#pragma once
#include "feder/shape.h"

namespace feder {

// Half the least distance of two parallel planes that hold a convex shape between them, among 13 directions and the
// normals of the faces that look along them, m: exact for boxes, round shapes and plates, else at most a tenth too
// large. 2D sections: in their plane. Of others Shape::inner_radius.
Real least_half_width(const Shape& shape);

// A point well inside a convex shape: the mean of what is farthest along the 8 diagonals of a cube: the
// centre of a box.
Vec3 inner_point(const Shape& shape);

}  // namespace feder
