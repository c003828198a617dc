// The shape of a signed distance field (feder/sdf.h): a field, and what is made of it once: surface samples for
// contacts, points of the hull, volume.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "bounds/box_tree.h"
#include "feder/memory.h"
#include "feder/sdf.h"
#include "geom/distance_field.h"
#include "geom/isosurface.h"
#include "geom/points_wide.h"

namespace feder {

class Sdf final : public Shape {
 public:
  static constexpr std::size_t kSamples = 800, kMostSamples = 12000;  // of plain shapes, and of detailed ones

  // SceneError when the field has no inside.
  explicit Sdf(DistanceField field);

  // What its maker found, before it is shared.
  void certify(Real error, std::vector<std::string> warnings) { error_ = error, warnings_ = std::move(warnings); }

  Aabb bounds(const Pose& pose) const override;
  MassProperties mass(Real density) const override;
  Real extent(const Vec3& center) const override;
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override;
  ShapeArguments arguments() const override;
  Real inner_radius() const override { return balls_.empty() ? Real(0) : balls_[balls_.size() / 2].radius; }

  const DistanceField& field() const { return field_; }
  SdfReport report() const;
  std::string describe() const override;
  std::span<const std::string> warnings() const override { return warnings_; }
  void surface(IsoMesh& mesh) const;

  // Surface points about `sample_spacing` apart with their outward normals, in the order of the tree's leaves.
  struct Sample {
    Vec3 at, normal;
  };
  std::span<const Sample> samples() const { return samples_; }
  const BoxTree& sample_tree() const { return tree_; }
  Real sample_spacing() const { return sample_spacing_; }  // m
  const Aabb& box() const { return box_; }                 // of the surface
  // Farthest point of the hull along `direction`, to half a per cent of the size.
  Vec3 hull_support(const Vec3& direction) const;
  // Balls inside, the largest first, that fill most of it: centre and radius, m.
  struct Ball {
    Vec3 center;
    Real radius;
  };
  std::span<const Ball> balls() const { return balls_; }
  std::span<const CompoundPart> ball_shapes() const { return ball_shapes_; }  // none in a build without spheres

 private:
  void take_samples(const IsoMesh& mesh);
  Real detail(const std::vector<Vec3>& at, const std::vector<Vec3>& normals) const;
  void take_hull(const IsoMesh& mesh);
  void take_balls();
  void integrate();
  Vec3 slope_across(const Vec3& p, Real d) const;

  DistanceField field_;
  Real error_ = -1;
  std::vector<std::string> warnings_;
  Aabb box_;
  std::vector<Sample> samples_;
  std::vector<Ball> balls_;
  std::vector<CompoundPart> ball_shapes_;
  Real sample_spacing_ = 0;
  Arena arena_{"sdf"};
  BoxTree tree_{arena_};
  std::vector<Lane8x3> hull_;
  std::uint32_t hull_points_ = 0;
  Real hull_slack_ = 0;  // m, by which the surface may stick out of the hull's points
  MassProperties unit_;  // at 1 kg/m3
};

// feder/sdf.h: make_sdf, the operations and sdf_offset.
ShapePtr build_sdf(const SdfDesc& desc);
ShapePtr build_sdf_at(const SdfDesc& desc, const Vec3& middle);  // of a function alone, in a box about `middle`
ShapePtr combine_sdf(SdfOperation operation, const Shape& a, const Shape& b, const Pose& place_b);
ShapePtr offset_sdf(const Shape& a, Real distance);
inline constexpr Real kFineBand = Real(1.05);  // cells: nearer to the surface an adaptive field is finest
DistanceField thinned(const DistanceField& dense, Real tolerance);
// Without sign, from where the values change it.
std::vector<float> surface_distances(const FieldLayout& at, const std::vector<float>& values);
std::vector<ShapePtr> parts_of_sdf(const ShapePtr& field);
bool is_sdf(const Shape& shape);

}  // namespace feder
