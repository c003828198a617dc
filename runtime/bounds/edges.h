// Volumes as edges, for drawing.
#pragma once
#include "feder/types.h"

namespace feder {

// Called with both ends; false: no more are wanted.
struct EdgeVisitor {
  bool (*call)(void* context, const Vec3& a, const Vec3& b);
  void* context;
  bool operator()(const Vec3& a, const Vec3& b) const { return call(context, a, b); }
};

// Each: false when the visitor wants no more.
bool edges_of_box(const Vec3& center, const Mat3& half_axes, EdgeVisitor visit);  // columns: from the centre to a side
bool edges_of_box(const Aabb& box, EdgeVisitor visit);
bool edges_of_ball(const Vec3& center, Real radius, EdgeVisitor visit);  // three circles

}  // namespace feder
