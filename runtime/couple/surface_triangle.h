// A triangle or a segment of a surface as a convex shape: its points rounded by half the thickness. Made where a test
// needs it.
#pragma once
#include <algorithm>
#include <cmath>

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

class SurfaceSegment final : public Shape {
 public:
  // From the origin to b.
  SurfaceSegment(const Vec3& b, Real radius) : Shape(any_convex_kind(), true, radius), b_(b) {
    const Vec3 across = std::abs(b[0]) < Real(0.6) * length(b) ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
    normal_ = normalized_or(cross(b, across), Vec3(0, 1, 0));
  }
  Aabb bounds(const Pose& pose) const override {
    Aabb box;
    box.include(pose.position), box.include(to_world(pose, b_));
    box.grow(radius());
    return box;
  }
  MassProperties mass(Real) const override { return {}; }
  Real extent(const Vec3& center) const override {
    return std::max(length(center), length(Vec3(b_ - center))) + radius();
  }
  bool raycast(const Vec3&, const Vec3&, RayHit&) const override { return false; }
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    return round_distance(p - closest_on_segment(p, Vec3(0, 0, 0), b_), radius(), normal_, normal);
  }
  Vec3 support(const Vec3& d) const override { return dot(b_, d) > 0 ? b_ : Vec3(0, 0, 0); }
  int face(const Vec3& d, Vec3* out) const override {
    const Real along = dot(d, b_);
    if (along * along > kAlong * kAlong * dot(b_, b_)) return out[0] = support(d), 1;
    out[0] = Vec3(0, 0, 0), out[1] = b_;
    return 2;
  }

 private:
  static constexpr Real kAlong = Real(0.9);  // cosine: beyond, an end looks that way and not the side
  Vec3 b_, normal_;
};

}  // namespace feder
