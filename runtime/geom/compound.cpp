// Compound: shapes with poses, moving as one. Colliders are made per part, so pair tests never see the whole.
// Weak spot: overlapping parts have their common mass twice.
#include "feder/error.h"
#include "feder/shape.h"
#include "geom/surfaces.h"

namespace feder {
namespace {

class Compound final : public Shape {
 public:
  Compound(std::vector<CompoundPart> parts, std::vector<CompoundPart> given, std::span<const ShapeSurface> surfaces)
      : Shape("compound", false), parts_(std::move(parts)), given_(std::move(given)),
        surfaces_(surfaces.begin(), surfaces.end()) {
    planar_ = true;
    for (const CompoundPart& p : parts_) planar_ = planar_ && p.shape->planar();
  }
  std::span<const CompoundPart> parts() const override { return parts_; }
  std::span<const ShapeSurface> surfaces() const override { return surfaces_; }

  Aabb bounds(const Pose& pose) const override {
    Aabb box;
    for (const CompoundPart& p : parts_) box.include(p.shape->bounds(pose * p.pose));
    return box;
  }
  // Overlapping parts count twice.
  MassProperties mass(Real density) const override {
    std::vector<MassProperties> all;
    for (const CompoundPart& p : parts_) all.push_back(transformed(p.shape->mass(density), p.pose));
    return combined(all);
  }
  Real extent(const Vec3& center) const override {
    Real far = 0;
    for (const CompoundPart& p : parts_) far = std::max(far, p.shape->extent(to_local(p.pose, center)));
    return far;
  }
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override {
    bool found = false;
    for (const CompoundPart& p : parts_) {
      RayHit h;
      if (!p.shape->raycast(to_local(p.pose, origin), rotate_inverse(p.pose.rotation, ray), h)) continue;
      if (found && h.fraction >= hit.fraction) continue;
      hit = {h.fraction, rotate(p.pose.rotation, h.normal)};
      found = true;
    }
    return found;
  }
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override {
    Real nearest = kInfinity;
    for (const CompoundPart& part : parts_) {
      Vec3 n;
      const Real d = part.shape->distance(to_local(part.pose, p), limit, n);
      if (!(d < nearest)) continue;
      nearest = d;
      normal = rotate(part.pose.rotation, n);
    }
    return nearest;
  }
  ShapeArguments arguments() const override { return {.parts = given_, .surfaces = surfaces_}; }
  // Of the parts, which must lie in the plane themselves: their poses may only turn about z.
  ShapePtr section() const override {
    std::vector<CompoundPart> flat;
    for (const CompoundPart& p : parts_) {
      if (std::abs(p.pose.rotation.x) > Real(1e-5) || std::abs(p.pose.rotation.y) > Real(1e-5))
        throw SceneError("compound: for a 2D section its parts may only be rotated about z");
      Pose pose = p.pose;
      pose.position[2] = 0;
      flat.push_back({p.shape->section(), pose, p.surface});
    }
    return make_compound(flat, surfaces_);
  }

 private:
  std::vector<CompoundPart> parts_;
  std::vector<CompoundPart> given_;  // before their rotations were scaled
  std::vector<ShapeSurface> surfaces_;
};

}  // namespace

namespace {

ShapePtr make(const ShapeInput& in) {
  std::vector<CompoundPart> parts(in.parts.begin(), in.parts.end());
  if (parts.empty()) throw SceneError("compound: expected at least one part");
  check_surfaces("compound", in.surfaces);
  for (CompoundPart& p : parts) {
    if (!p.shape) throw SceneError("compound: a part has no shape");
    if (!p.shape->parts().empty()) throw SceneError("compound: a part is a compound itself");
    if (!is_finite(p.pose.position)) throw SceneError("compound: a part's position is not finite");
    if (p.surface > in.surfaces.size()) fail_surface_number("compound: a part", p.surface, in.surfaces);
    p.pose.rotation = normalized(p.pose.rotation);
  }
  return std::make_shared<Compound>(std::move(parts), std::vector<CompoundPart>(in.parts.begin(), in.parts.end()),
                                    in.surfaces);
}

}  // namespace

ShapeKind geom_compound() {
  return {"compound",
          "{ {shape=, position=, rotation=, friction=, ...}, ... }",
          "several shapes in one; what a part states of its surface takes the place of the body's",
          {.whole = false},
          {{"parts", ShapeArgumentType::parts}},
          make,
          [] {
            const Pose left{vec3(-1, 0, 0), {}};
            const Pose right{vec3(1, Real(0.5), 0), from_axis_angle(vec3(0, 0, 1), Real(0.5))};
            const ShapeSurface rubber[1] = {{.numbers = {.restitution = 1, .rolling_friction = Real(0.01)}}};
            const std::vector<CompoundPart> parts = {{make_box(1, 1, 1), left}, {make_sphere(Real(0.5)), right, 1}};
            return std::vector<ShapePtr>{make_compound(parts, rubber)};
          }};
}

}  // namespace feder
