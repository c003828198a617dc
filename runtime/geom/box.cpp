// Box: bounds, mass, support, faces, distance and rays.
// Weak spot: a ray along a face, exactly on it, counts as a hit.
#include "geom/box.h"

#include "geom/sizes.h"

namespace feder {

Aabb Box::bounds(const Pose& pose) const {
  const Mat3 r = to_matrix(pose.rotation);
  Vec3 e;
  for (int i = 0; i < 3; ++i)
    e[i] = std::abs(r(i, 0)) * half_[0] + std::abs(r(i, 1)) * half_[1] + std::abs(r(i, 2)) * half_[2];
  return {pose.position - e, pose.position + e};
}

MassProperties Box::mass(Real density) const {
  const Real m = density * 8 * half_[0] * half_[1] * half_[2];
  const Real x = half_[0] * half_[0], y = half_[1] * half_[1], z = half_[2] * half_[2];
  MassProperties p{m, Vec3::Zero(), Mat3::Zero()};
  p.inertia(0, 0) = m / 3 * (y + z);
  p.inertia(1, 1) = m / 3 * (x + z);
  p.inertia(2, 2) = m / 3 * (x + y);
  return p;
}

Real Box::extent(const Vec3& c) const {
  return length(vec3(std::abs(c[0]) + half_[0], std::abs(c[1]) + half_[1], std::abs(c[2]) + half_[2]));
}

// Slabs: the ray is inside between its last entry and its first exit (Kay and Kajiya 1986).
bool Box::raycast(const Vec3& o, const Vec3& d, RayHit& hit) const {
  Real enter = 0, leave = 1;
  int axis = -1;
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (std::abs(o[i]) > half_[i]) return false;
      continue;
    }
    const Real side = d[i] > 0 ? half_[i] : -half_[i];
    const Real t0 = (-side - o[i]) / d[i], t1 = (side - o[i]) / d[i];
    if (t0 > enter) enter = t0, axis = i;
    if (t1 < leave) leave = t1;
    if (enter > leave) return false;
  }
  hit = {enter, Vec3::Zero()};
  if (axis >= 0) hit.normal[axis] = d[axis] > 0 ? Real(-1) : Real(1);
  return true;
}

int Box::face(const Vec3& d, Vec3* points) const {
  const Real x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
  const int k = x >= y && x >= z ? 0 : (y >= z ? 1 : 2);
  const Real s = d[k] < 0 ? Real(-1) : Real(1);
  const int u = (k + 1) % 3, v = (k + 2) % 3;
  constexpr Real kU[4] = {1, -1, -1, 1}, kV[4] = {1, 1, -1, -1};
  for (int i = 0; i < 4; ++i) {
    points[i][k] = s * half_[k];
    points[i][u] = s * kU[i] * half_[u];  // a mirrored u keeps the loop counter-clockwise on the far side
    points[i][v] = kV[i] * half_[v];
  }
  return 4;
}

// Outside: from the nearest point of the box; inside: to the nearest face.
Real Box::distance(const Vec3& p, Real, Vec3& normal) const {
  const Vec3 beyond = p.cwiseAbs() - half_;
  Vec3 outside = beyond.cwiseMax(Real(0));
  for (int k = 0; k < 3; ++k)
    if (p[k] < 0) outside[k] = -outside[k];
  const Real d = length(outside);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (beyond[k] > beyond[axis]) axis = k;
  Vec3 face = Vec3::Zero();
  face[axis] = p[axis] < 0 ? Real(-1) : Real(1);
  normal = d > 0 ? normalized_or(outside, face) : face;
  return d > 0 ? d : beyond[axis];
}

ShapePtr Box::section() const {
  const Vec2 corners[4] = {{-half_[0], -half_[1]}, {half_[0], -half_[1]}, {half_[0], half_[1]}, {-half_[0], half_[1]}};
  return make_polygon(corners);
}

ShapeKind geom_box() {
  return {
      "box",
      "(width, height, [depth])",
      "a box of full sizes; depth may be left out in 2D",
      {.convex = true},
      {{"width", ShapeArgumentType::size}, {"height", ShapeArgumentType::size}, {"depth", ShapeArgumentType::size, 1}},
      [](const ShapeInput& in) -> ShapePtr {
        return std::make_shared<Box>(vec3(positive_size(in.size(0), "box", "width"),
                                          positive_size(in.size(1), "box", "height"),
                                          positive_size(in.size(2), "box", "depth")) /
                                     2);
      },
      [] {
        return std::vector<ShapePtr>{make_box(1, 2, 3), make_box(2, Real(0.05), 2),
                                     make_box(Real(0.01), Real(0.02), Real(0.01))};
      },
      false,
      "cube, cuboid"};
}

}  // namespace feder
