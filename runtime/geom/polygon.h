// Polygon: a 2D convex outline in the xy plane, optionally rounded; two points with a radius are a 2D capsule.
// Masses are per metre of depth.
#pragma once
#include "feder/shape.h"

namespace feder {

class Polygon final : public Shape {
 public:
  // `points`: convex, counter-clockwise, 2..kMaxFacePoints.
  Polygon(std::vector<Vec2> points, Real radius);
  std::span<const Vec2> points() const { return points_; }
  std::span<const Vec2> normals() const { return normals_; }  // of the edge from point i to i + 1, outward
  Real reach() const { return reach_; }                       // farthest corner from the origin of the frame, m
  Real size() const { return size_; }                         // and from the first corner, m

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real density) const override;
  Real extent(const Vec3& center) const override;
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Vec3 support(const Vec3& direction) const override;
  int face(const Vec3& direction, Vec3* points) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapeArguments arguments() const override;
  ShapePtr section() const override;

 private:
  std::vector<Vec2> points_, normals_;
  Real reach_ = 0, size_ = 0;
};

// Convex hull, counter-clockwise from the lowest x, without points on its edges (Andrew's monotone chain).
std::vector<Vec2> convex_hull_2d(std::span<const Vec2> points);

}  // namespace feder
