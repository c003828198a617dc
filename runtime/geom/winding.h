// Winding number of a surface of triangles about a point: how often it goes round it. 1 inside a closed surface whose
// triangles are counterclockwise from outside, 0 outside; fractions where it is open. Source: sum of solid angles, Van
// Oosterom & Strackee 1983; generalised to open surfaces by Jacobson, Kavan & Sorkine-Hornung, "Robust Inside-Outside
// Segmentation using Generalized Winding Numbers", SIGGRAPH 2013.
#pragma once
#include <span>

#include "feder/types.h"

namespace feder {

// `corners`: three per triangle. Of a point on the surface: a half, or what rounding makes of it.
double winding_number(std::span<const Vec3> corners, const Vec3& p);

}  // namespace feder
