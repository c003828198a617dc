// Circle: the 2D sphere, a point in the xy plane rounded by its radius. Masses are per metre of depth.
// Weak spot: as of the sphere, rays from far away lose digits.
#include "feder/shape.h"
#include "geom/sizes.h"

namespace feder {
namespace {

class Circle final : public Shape {
 public:
  explicit Circle(Real r) : Shape("circle", true, r) { planar_ = true; }
  Aabb bounds(const Pose& pose) const override {
    return {pose.position - Vec3::Constant(radius_), pose.position + Vec3::Constant(radius_)};
  }
  MassProperties mass(Real density) const override {
    const Real m = density * kPi * radius_ * radius_, i = m * radius_ * radius_ / 2;
    MassProperties p{m, Vec3::Zero(), Mat3::Zero()};
    p.inertia(0, 0) = p.inertia(1, 1) = i / 2;
    p.inertia(2, 2) = i;
    return p;
  }
  Real extent(const Vec3& c) const override { return length(c) + radius_; }
  bool raycast(const Vec3& o, const Vec3& d, RayHit& hit) const override {
    const Real c = o[0] * o[0] + o[1] * o[1] - radius_ * radius_;
    if (c <= 0) return hit = {0, Vec3::Zero()}, true;
    const Real a = d[0] * d[0] + d[1] * d[1], b = o[0] * d[0] + o[1] * d[1], disc = b * b - a * c;
    if (!(a > 0) || b >= 0 || disc < 0) return false;
    const Real t = c / (-b + std::sqrt(disc));  // the nearer root without cancellation
    if (t > 1) return false;
    const Vec3 p = vec3(o[0] + t * d[0], o[1] + t * d[1], 0);
    return hit = {t, p / length(p)}, true;
  }
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    return round_distance(vec3(p[0], p[1], 0), radius_, vec3(0, 1, 0), normal);
  }
  Vec3 support(const Vec3&) const override { return Vec3::Zero(); }
  ShapeArguments arguments() const override { return {.sizes = {radius_}}; }
  ShapePtr section() const override { return make_circle(radius_); }
};

}  // namespace

ShapeKind geom_circle() {
  return {"circle",
          "(radius)",
          "for worlds with dimension = 2",
          {.convex = true, .planar = true},
          {{"radius", ShapeArgumentType::size}},
          [](const ShapeInput& in) -> ShapePtr {
            return std::make_shared<Circle>(positive_size(in.size(0), "circle", "radius"));
          },
          [] {
            return std::vector<ShapePtr>{make_circle(1), make_circle(Real(0.01))};
          }};
}

}  // namespace feder
