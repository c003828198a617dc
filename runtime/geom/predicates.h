// Signs of volumes without error, and what follows from them: whether a segment passes through a triangle. A filter
// (double arithmetic with a bound of its error) answers nearly always; what is as good as flat is decided exactly, by
// sums of doubles that do not overlap (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
// Geometric Predicates", 1997). Exact for finite coordinates whose products neither overflow nor underflow: all floats,
// and doubles of sizes from 1e-90 to 1e90. Convention for what touches: it does not pass through. Weak spot: a segment
// that meets a mesh exactly in an edge or a vertex passes through none of the triangles there.
// tests/geom/test_predicates.cpp.
#pragma once
#include "feder/types.h"

namespace feder {

// Sign of (b - a) . ((c - a) x (d - a)): 1, -1, or 0 when the four points lie in one plane, or one is not finite.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

// Does the open segment p q pass through the inside of the triangle a b c, from one side of its plane to the other?
bool passes_through(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace feder
