#include "bounds/edges.h"

#include <cmath>

namespace feder {

bool edges_of_box(const Vec3& center, const Mat3& half_axes, EdgeVisitor visit) {
  for (int axis = 0; axis < 3; ++axis)
    for (unsigned corner = 0; corner < 4; ++corner) {
      const Vec3 u = half_axes.col((axis + 1) % 3), v = half_axes.col((axis + 2) % 3), along = half_axes.col(axis);
      const Vec3 middle = center + (corner & 1 ? u : Vec3(-u)) + (corner & 2 ? v : Vec3(-v));
      if (!visit(middle - along, middle + along)) return false;
    }
  return true;
}

bool edges_of_box(const Aabb& box, EdgeVisitor visit) {
  if (box.empty()) return true;
  const Vec3 half = Real(0.5) * (box.hi - box.lo);
  Mat3 axes = Mat3::Zero();
  for (int k = 0; k < 3; ++k) axes(k, k) = half[k];
  return edges_of_box(Vec3(box.lo + half), axes, visit);
}

bool edges_of_ball(const Vec3& center, Real radius, EdgeVisitor visit) {
  constexpr int kSegments = 24;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](int k) {
      const double angle = 2 * 3.14159265358979323846 * k / kSegments;
      Vec3 p = center;
      p[(axis + 1) % 3] += radius * static_cast<Real>(std::cos(angle));
      p[(axis + 2) % 3] += radius * static_cast<Real>(std::sin(angle));
      return p;
    };
    for (int k = 0; k < kSegments; ++k)
      if (!visit(at(k), at((k + 1) % kSegments))) return false;
  }
  return true;
}

}  // namespace feder
