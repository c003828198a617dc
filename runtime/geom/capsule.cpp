// Capsule: a segment along y rounded by the radius.
// Weak spot: rays solve their quadratic in Real, so those from thousands of radii away lose digits.
#include <algorithm>

#include "feder/shape.h"
#include "geom/sizes.h"

namespace feder {
namespace {

class Capsule final : public Shape {
 public:
  Capsule(Real radius, Real height)
      : Shape("capsule", true, radius), half_(std::max(Real(0), height / 2 - radius)), height_(height) {}

  Aabb bounds(const Pose& pose) const override {
    const Vec3 y = rotate(pose.rotation, vec3(0, half_, 0)).cwiseAbs() + Vec3::Constant(radius_);
    return {pose.position - y, pose.position + y};
  }
  MassProperties mass(Real density) const override {
    const Real r = radius_, h = 2 * half_, rod = density * kPi * r * r * h,
               ball = density * Real(4) / 3 * kPi * r * r * r;
    // a half ball's centre is 3/8 r from its flat side
    const Real across =
        rod * (h * h / 12 + r * r / 4) + ball * (Real(0.4) * r * r + half_ * half_ + Real(0.75) * half_ * r);
    MassProperties p{rod + ball, Vec3::Zero(), Mat3::Zero()};
    p.inertia(0, 0) = p.inertia(2, 2) = across;
    p.inertia(1, 1) = rod * r * r / 2 + ball * Real(0.4) * r * r;
    return p;
  }
  Real extent(const Vec3& c) const override { return length(vec3(c[0], std::abs(c[1]) + half_, c[2])) + radius_; }
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override;
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    return round_distance(p - vec3(0, clamp(p[1], -half_, half_), 0), radius_, vec3(1, 0, 0), normal);
  }
  Vec3 support(const Vec3& d) const override { return vec3(0, d[1] < 0 ? -half_ : half_, 0); }
  int face(const Vec3& d, Vec3* points) const override {
    if (half_ == 0 || std::abs(d[1]) > Real(0.9)) return points[0] = support(d), 1;
    points[0] = vec3(0, -half_, 0), points[1] = vec3(0, half_, 0);
    return 2;
  }
  ShapeArguments arguments() const override { return {.sizes = {radius_, height_}}; }
  ShapePtr section() const override {
    if (half_ == 0) return make_circle(radius_);
    const Vec2 ends[2] = {{0, -half_}, {0, half_}};
    return make_polygon(ends, radius_);
  }

 private:
  Real half_;    // of the segment, m
  Real height_;  // with its caps, m
};

// The side as an endless cylinder; hits beyond its ends go to the ball there.
bool Capsule::raycast(const Vec3& o, const Vec3& d, RayHit& hit) const {
  const Vec3 axis = vec3(0, clamp(o[1], -half_, half_), 0), off = o - axis;
  if (dot(off, off) <= radius_ * radius_) return hit = {0, Vec3::Zero()}, true;
  const Real a = d[0] * d[0] + d[2] * d[2], b = o[0] * d[0] + o[2] * d[2];
  const Real c = o[0] * o[0] + o[2] * o[2] - radius_ * radius_, disc = b * b - a * c;
  if (disc < 0 || (c > 0 && b >= 0)) return false;
  if (c > 0) {
    const Real t = c / (-b + std::sqrt(disc)), y = o[1] + t * d[1];
    if (std::abs(y) <= half_) {
      if (t > 1) return false;
      return hit = {t, vec3(o[0] + t * d[0], 0, o[2] + t * d[2]) / radius_}, true;
    }
  }
  bool found = false;
  for (const Real end : {-half_, half_}) {
    const Vec3 p = o - vec3(0, end, 0);
    const Real cc = dot(p, p) - radius_ * radius_, aa = dot(d, d), bb = dot(p, d), q = bb * bb - aa * cc;
    if (bb >= 0 || q < 0) continue;
    const Real t = cc / (-bb + std::sqrt(q));
    if (t > 1 || (found && t >= hit.fraction)) continue;
    hit = {t, (p + t * d) / radius_};
    found = true;
  }
  return found;
}

ShapePtr make(const ShapeInput& in) {
  const Real radius = in.size(0), height = in.size(1);
  positive_size(radius, "capsule", "radius");
  positive_size(height, "capsule", "height");
  if (height < 2 * radius * (1 - Real(1e-6)))
    throw SceneError("capsule: expected a height of at least twice the radius " + std::to_string(radius) + ", got " +
                     std::to_string(height));
  return std::make_shared<Capsule>(radius, height);
}

}  // namespace

ShapeKind geom_capsule() {
  return {"capsule",
          "(radius, height)",
          "along y, whole height with its caps",
          {.convex = true},
          {{"radius", ShapeArgumentType::size}, {"height", ShapeArgumentType::size}},
          make,
          [] {
            return std::vector<ShapePtr>{make_capsule(Real(0.5), 3), make_capsule(Real(0.02), Real(0.05)),
                                         make_capsule(1, 2)};
          }};
}

}  // namespace feder
