// Plane: the half-space n.x <= d is solid. Has neither mass nor support function; pair tests read n and d.
#pragma once
#include "feder/shape.h"

namespace feder {

class Plane final : public Shape {
 public:
  Plane(const Vec3& normal, Real distance, ShapeArguments given)
      : Shape("plane", false), normal_(normal), distance_(distance), given_(std::move(given)) {}
  const Vec3& normal() const { return normal_; }  // unit, out of the solid
  Real distance() const { return distance_; }     // of the surface from the origin along the normal, m

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real) const override { return {}; }
  Real extent(const Vec3&) const override { return kInfinity; }
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    normal = normal_;
    return dot(p, normal_) - distance_;
  }
  bool half_space(Vec3& normal, Real& distance) const override { return normal = normal_, distance = distance_, true; }
  ShapeArguments arguments() const override { return given_; }
  ShapePtr section() const override;

 private:
  Vec3 normal_;
  Real distance_;
  ShapeArguments given_;  // before they were scaled
};

}  // namespace feder
