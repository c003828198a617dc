// Convex hull of a point cloud: corners, polygonal faces, edges.
#pragma once
#include "feder/shape.h"
#include "geom/points_wide.h"

namespace feder {

inline constexpr int kMaxHullCorners = 256;

struct HullFace {
  Vec3 normal = Vec3::Zero();  // unit, outward
  Real offset = 0;             // normal . x = offset on the face
  std::uint16_t first = 0;     // in Hull::loops
  std::uint16_t count = 0;     // corners, counter-clockwise seen from outside
};

// What quickhull finds; a plain value.
struct HullData {
  std::vector<Vec3> corners;
  std::vector<HullFace> faces;
  std::vector<std::uint16_t> loops;  // corner numbers of the faces, one after another
  const Vec3& corner(const HullFace& f, int i) const { return corners[loops[f.first + static_cast<std::size_t>(i)]]; }
};

// SceneError when the points are too few, not finite, flat, or span too many corners.
HullData build_hull(std::span<const Vec3> points);

class Hull final : public Shape {
 public:
  Hull(HullData data, std::span<const Vec3> points);  // of those
  const HullData& data() const { return data_; }

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real density) const override;
  Real extent(const Vec3& center) const override;
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Vec3 support(const Vec3& direction) const override;
  int face(const Vec3& direction, Vec3* points) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapeArguments arguments() const override { return {.points = points_}; }
  ShapePtr section() const override;

 private:
  HullData data_;
  std::vector<Lane8x3> corner_lanes_, normal_lanes_;  // of data_, eight to a group
  const PointKernel* kernel_;
  std::vector<Vec3> points_;  // as given: quickhull's corners depend on their order
};

}  // namespace feder
