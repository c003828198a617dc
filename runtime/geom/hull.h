// Convex hull of a point cloud as a shape.
#pragma once
#include <memory>
#include <mutex>

#include "bounds/quickhull.h"
#include "feder/shape.h"
#include "geom/points_wide.h"

namespace feder {

class FeatureGraph;

class Hull final : public Shape {
 public:
  Hull(HullData data, std::span<const Vec3> points);  // of those
  const HullData& data() const { return data_; }
  const FeatureGraph& features() const;  // made at the first call, by any thread: geom/hull_features.cpp

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
  mutable std::once_flag features_made_;
  mutable std::shared_ptr<const FeatureGraph> features_;
};

}  // namespace feder
