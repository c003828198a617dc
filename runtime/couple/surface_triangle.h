// A triangle of a surface as a convex shape: three points rounded by half the thickness. Made where a test needs it.
#pragma once
#include "feder/shape.h"
#include "geom/closest.h"

namespace feder {

class SurfaceTriangle final : public Shape {
 public:
  // Corners in a frame at the first of them.
  SurfaceTriangle(const Vec3& b, const Vec3& c, Real radius)
      : Shape(any_convex_kind(), true, radius), p_{Vec3(0, 0, 0), b, c} {
    normal_ = normalized_or(cross(b, c), Vec3(0, 1, 0));
  }
  Aabb bounds(const Pose& pose) const override {
    Aabb box;
    for (const Vec3& p : p_) box.include(to_world(pose, p));
    box.grow(radius());
    return box;
  }
  MassProperties mass(Real) const override { return {}; }
  Real extent(const Vec3& center) const override {
    Real most = 0;
    for (const Vec3& p : p_) most = std::max(most, length(p - center));
    return most + radius();
  }
  bool raycast(const Vec3&, const Vec3&, RayHit&) const override { return false; }
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    return round_distance(p - closest_on_triangle(p, p_[0], p_[1], p_[2]), radius(), normal_, normal);
  }
  Vec3 support(const Vec3& d) const override {
    const Real a = dot(p_[0], d), b = dot(p_[1], d), c = dot(p_[2], d);
    return a >= b && a >= c ? p_[0] : b >= c ? p_[1] : p_[2];
  }
  int face(const Vec3& d, Vec3* out) const override {
    const Real up = dot(d, normal_);
    if (up > Real(0.5) || up < Real(-0.5)) {
      const bool front = up > 0;
      out[0] = p_[0], out[1] = p_[front ? 1 : 2], out[2] = p_[front ? 2 : 1];
      return 3;
    }
    // edge-on: all but the lowest corner along d
    const Real along[3] = {dot(p_[0], d), dot(p_[1], d), dot(p_[2], d)};
    const int low = along[0] <= along[1] && along[0] <= along[2] ? 0 : along[1] <= along[2] ? 1 : 2;
    out[0] = p_[(low + 1) % 3], out[1] = p_[(low + 2) % 3];
    return 2;
  }

 private:
  Vec3 p_[3], normal_;
};

}  // namespace feder
