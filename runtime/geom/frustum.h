// Frustum: a circle at the bottom, one at the top (radius 0: a tip), straight sides. Cylinder and cone are two of its
// kinds.
#pragma once
#include "feder/shape.h"

namespace feder {

class Frustum final : public Shape {
 public:
  Frustum(const char* kind, Real bottom, Real top, Real height)
      : Shape(kind, true), bottom_(bottom), top_(top), half_(height / 2) {}

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real density) const override;
  Real extent(const Vec3& center) const override;
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Vec3 support(const Vec3& direction) const override;
  int face(const Vec3& direction, Vec3* points) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapePtr section() const override;

 private:
  Real slope() const { return (bottom_ - top_) / (2 * half_); }  // radius lost per metre up

  Real bottom_, top_, half_;  // radii and half the height, m
};

}  // namespace feder
