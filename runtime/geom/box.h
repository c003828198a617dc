// Box: half sizes along its axes. A header of its own because the box pair tests read the half sizes.
#pragma once
#include "feder/shape.h"

namespace feder {

class Box final : public Shape {
 public:
  explicit Box(const Vec3& half) : Shape("box", true), half_(half) {}
  const Vec3& half() const { return half_; }  // m

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real density) const override;
  Real extent(const Vec3& center) const override;
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Vec3 support(const Vec3& d) const override {
    return vec3(d[0] < 0 ? -half_[0] : half_[0], d[1] < 0 ? -half_[1] : half_[1], d[2] < 0 ? -half_[2] : half_[2]);
  }
  int face(const Vec3& direction, Vec3* points) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapeArguments arguments() const override { return {.sizes = {2.0 * half_[0], 2.0 * half_[1], 2.0 * half_[2]}}; }
  ShapePtr section() const override;

 private:
  Vec3 half_;
};

}  // namespace feder
