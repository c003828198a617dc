// Sphere: a point rounded by its radius.
// Weak spot: rays solve their quadratic in Real, so those from thousands of radii away lose digits.
#include "feder/shape.h"
#include "geom/sizes.h"

namespace feder {
namespace {

class Sphere final : public Shape {
 public:
  explicit Sphere(Real r) : Shape("sphere", true, r) {}
  Aabb bounds(const Pose& pose) const override {
    return {pose.position - Vec3::Constant(radius_), pose.position + Vec3::Constant(radius_)};
  }
  MassProperties mass(Real density) const override {
    const Real m = density * Real(4) / 3 * kPi * radius_ * radius_ * radius_;
    return {m, Vec3::Zero(), Mat3::Identity() * (Real(0.4) * m * radius_ * radius_)};
  }
  Real extent(const Vec3& center) const override { return length(center) + radius_; }
  bool raycast(const Vec3& o, const Vec3& d, RayHit& hit) const override {
    const Real c = dot(o, o) - radius_ * radius_;
    if (c <= 0) return hit = {0, Vec3::Zero()}, true;
    const Real a = dot(d, d), b = dot(o, d), disc = b * b - a * c;
    if (!(a > 0) || b >= 0 || disc < 0) return false;
    const Real t = c / (-b + std::sqrt(disc));  // the nearer root without cancellation
    if (t > 1) return false;
    const Vec3 p = o + t * d;
    return hit = {t, p / length(p)}, true;
  }
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    return round_distance(p, radius_, vec3(0, 1, 0), normal);
  }
  Vec3 support(const Vec3&) const override { return Vec3::Zero(); }
  ShapeArguments arguments() const override { return {.sizes = {radius_}}; }
  ShapePtr section() const override { return make_circle(radius_); }
};

}  // namespace

ShapeKind geom_sphere() {
  return {"sphere",
          "(radius)",
          "a ball",
          {.convex = true},
          {{"radius", ShapeArgumentType::size}},
          [](const ShapeInput& in) -> ShapePtr {
            return std::make_shared<Sphere>(positive_size(in.size(0), "sphere", "radius"));
          },
          [] {
            return std::vector<ShapePtr>{make_sphere(1), make_sphere(Real(0.01))};
          },
          false,
          "ball"};
}

}  // namespace feder
