#include "geom/width.h"

#include <algorithm>

namespace feder {
namespace {

// Diagonals and axes of a cube: each stands for its opposite too.
constexpr int kDirections = 13, kDiagonals = 4;
constexpr int kDirection[kDirections][3] = {{1, 1, 1},  {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}, {1, 0, 0},
                                            {0, 1, 0},  {0, 0, 1},  {1, 1, 0},  {1, -1, 0}, {1, 0, 1},
                                            {1, 0, -1}, {0, 1, 1},  {0, 1, -1}};

Vec3 direction(int k) { return Vec3(Real(kDirection[k][0]), Real(kDirection[k][1]), Real(kDirection[k][2])); }

Real width_along(const Shape& shape, const Vec3& n) {
  return dot(n, shape.support(n)) - dot(n, shape.support(-n)) + 2 * shape.radius();
}

// Normal of the face that looks along `d`; zero when an edge or a corner does.
Vec3 face_normal(const Shape& shape, const Vec3& d) {
  Vec3 corner[kMaxFacePoints];
  const int count = shape.face(d, corner);
  Vec3 sum = Vec3::Zero();
  for (int k = 1; k + 1 < count; ++k) sum += cross(corner[k] - corner[0], corner[k + 1] - corner[0]);
  return normalized_or(sum, Vec3::Zero());
}

}  // namespace

Real least_half_width(const Shape& shape) {
  if (!shape.convex()) return shape.inner_radius();
  Real least = kInfinity;
  for (int k = 0; k < kDirections; ++k) {
    const Vec3 d = normalized_or(direction(k), Vec3(0, 1, 0));
    if (shape.planar() && d[2] != 0) continue;
    least = std::min(least, width_along(shape, d));
    if (shape.planar()) continue;
    for (const Vec3& side : {d, Vec3(-d)})
      if (const Vec3 n = face_normal(shape, side); !n.isZero(0)) least = std::min(least, width_along(shape, n));
  }
  return least / 2;
}

Vec3 inner_point(const Shape& shape) {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < kDiagonals; ++k) sum += shape.support(direction(k)) + shape.support(-direction(k));
  return sum / Real(2 * kDiagonals);
}

}  // namespace feder
