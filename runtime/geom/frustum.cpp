// Frustum: a convex surface of revolution about y with straight sides.
// Masses by the integral over discs. Weak spot: for clipping a cap is an inscribed polygon of kCapCorners, which a body
// standing on it rests on.
#include "geom/frustum.h"

#include "geom/closest.h"

namespace feder {
namespace {

constexpr int kCapCorners = 16;  // a cap's outline for clipping: inscribed, 2 % short between its corners

// The outline is fixed in the shape's frame, so that contact points keep their identity.
struct CapTable {
  Real x[kCapCorners], z[kCapCorners];
  CapTable() {
    for (int i = 0; i < kCapCorners; ++i) sin_cos(2 * kPi * Real(i) / kCapCorners, z[i], x[i]);
  }
};

int cap(Real radius, Real y, Vec3* points) {
  static const CapTable table;
  for (int i = 0; i < kCapCorners; ++i)
    points[i] = vec3(radius * table.x[i], y, y > 0 ? -radius * table.z[i] : radius * table.z[i]);
  return kCapCorners;
}

class Frustum final : public Shape {
 public:
  Frustum(const char* kind, Real bottom, Real top, Real height)
      : Shape(kind, true), bottom_(bottom), top_(top), half_(height / 2) {}

  Aabb bounds(const Pose& pose) const override {
    const Vec3 axis = rotate(pose.rotation, vec3(0, 1, 0));
    Aabb box;
    for (int i = 0; i < 3; ++i) {
      const Real side = std::sqrt(std::max(Real(0), 1 - axis[i] * axis[i])), up = half_ * axis[i];
      box.lo[i] = pose.position[i] + std::min(up - top_ * side, -up - bottom_ * side);
      box.hi[i] = pose.position[i] + std::max(up + top_ * side, -up + bottom_ * side);
    }
    return box;
  }

  // Integrals over s = 0 (bottom) .. 1 (top) of powers of the radius b (1 - s) + t s.
  MassProperties mass(Real density) const override {
    const double b = bottom_, t = top_, h = 2.0 * half_, pi = kPi;
    const double r2 = (b * b + b * t + t * t) / 3, r2s = (b * b + 2 * b * t + 3 * t * t) / 12;
    const double r2ss = (b * b + 3 * b * t + 6 * t * t) / 30;
    const double r4 = (b * b * b * b + b * b * b * t + b * b * t * t + b * t * t * t + t * t * t * t) / 5;
    const double m = density * pi * h * r2, middle = r2s / r2;
    const double across = density * pi * h * (r4 / 4 + h * h * (r2ss - r2 * middle * middle));
    MassProperties p{Real(m), vec3(0, Real(h * (middle - 0.5)), 0), Mat3::Zero()};
    p.inertia(0, 0) = p.inertia(2, 2) = Real(across);
    p.inertia(1, 1) = Real(density * pi * h * r4 / 2);
    return p;
  }

  Real extent(const Vec3& c) const override {
    const Real out = std::sqrt(c[0] * c[0] + c[2] * c[2]);
    return std::max(std::hypot(out + bottom_, c[1] + half_), std::hypot(out + top_, c[1] - half_));
  }

  // Inside is the slab |y| <= half and x^2 + z^2 <= (middle radius - slope y)^2. In double: the quadratic cancels.
  bool raycast(const Vec3& o, const Vec3& d, RayHit& hit) const override {
    double enter = 0, leave = 1;
    bool by_cap = false;
    if (d[1] == 0) {
      if (std::abs(o[1]) > half_) return false;
    } else {
      const double t0 = (-double(half_) - o[1]) / d[1], t1 = (double(half_) - o[1]) / d[1];
      if (std::min(t0, t1) > enter) enter = std::min(t0, t1), by_cap = true;
      leave = std::min(leave, std::max(t0, t1));
      if (enter > leave) return false;
    }
    const double k = (double(bottom_) - top_) / (2.0 * half_), middle = (double(bottom_) + top_) / 2;
    const double ro = middle - k * o[1], rd = -k * d[1];  // radius along the ray
    const double a = double(d[0]) * d[0] + double(d[2]) * d[2] - rd * rd;
    const double b = double(o[0]) * d[0] + double(o[2]) * d[2] - ro * rd;
    const double c = double(o[0]) * o[0] + double(o[2]) * o[2] - ro * ro;
    if ((a * enter + 2 * b) * enter + c <= 0) {
      hit = {Real(enter), vec3(0, by_cap ? (d[1] > 0 ? Real(-1) : Real(1)) : Real(0), 0)};
      return true;
    }
    // the first root after `enter` where the ray goes in
    const double disc = b * b - a * c;
    if (disc < 0) return false;
    const double q = -(b + (b < 0 ? -std::sqrt(disc) : std::sqrt(disc)));
    double t = std::numeric_limits<double>::infinity();
    for (const double root : {q / a, c / q})
      if (root > enter && root <= leave && a * root + b <= 0 && root < t) t = root;
    if (!(t <= leave)) return false;
    const Vec3 p = o + Real(t) * d;
    hit = {Real(t), normalized_or(vec3(p[0], slope() * std::sqrt(p[0] * p[0] + p[2] * p[2]), p[2]), vec3(0, 1, 0))};
    return true;
  }

  Vec3 support(const Vec3& d) const override {
    const Real out = std::sqrt(d[0] * d[0] + d[2] * d[2]);
    const bool up = top_ * out + half_ * d[1] >= bottom_ * out - half_ * d[1];
    const Real r = out > 0 ? (up ? top_ : bottom_) / out : Real(0);
    return vec3(d[0] * r, up ? half_ : -half_, d[2] * r);
  }

  int face(const Vec3& d, Vec3* points) const override {
    const Real out = std::sqrt(d[0] * d[0] + d[2] * d[2]), k = slope();
    const Real side = (out + k * d[1]) / std::sqrt(1 + k * k);
    if (-d[1] >= side) return cap(bottom_, -half_, points);
    if (top_ > 0 && d[1] >= side) return cap(top_, half_, points);
    const Real x = out > 0 ? d[0] / out : Real(1), z = out > 0 ? d[2] / out : Real(0);
    points[0] = vec3(x * bottom_, -half_, z * bottom_);
    points[1] = vec3(x * top_, half_, z * top_);
    return 2;
  }

  // In the half-plane (distance from the axis, y): a convex outline of bottom, side and top.
  Real distance(const Vec3& p, Real, Vec3& normal) const override {
    const Real out = std::sqrt(p[0] * p[0] + p[2] * p[2]), k = slope(), slant = std::sqrt(1 + k * k);
    const Vec3 around = out > 0 ? vec3(p[0] / out, 0, p[2] / out) : vec3(1, 0, 0);
    const Real side = (out + k * p[1] - (bottom_ + top_) / 2) / slant, cap = std::abs(p[1]) - half_;
    if (side <= 0 && cap <= 0) {
      normal = cap > side ? vec3(0, p[1] < 0 ? Real(-1) : Real(1), 0) : Vec3((around + vec3(0, k, 0)) / slant);
      return std::max(side, cap);
    }
    const Vec3 q = vec3(out, p[1], 0);
    const Vec3 ends[2][2] = {{vec3(0, -half_, 0), vec3(bottom_, -half_, 0)}, {vec3(0, half_, 0), vec3(top_, half_, 0)}};
    Vec3 nearest = closest_on_segment(q, ends[0][1], ends[1][1]);
    for (const auto& e : ends) {
      const Vec3 on = closest_on_segment(q, e[0], e[1]);
      if (dot(q - on, q - on) < dot(q - nearest, q - nearest)) nearest = on;
    }
    const Vec3 flat = normalized_or(q - nearest, vec3(1, 0, 0));
    normal = flat[0] * around + vec3(0, flat[1], 0);
    return length(q - nearest);
  }

  ShapeArguments arguments() const override { return {.sizes = {bottom_, 2.0 * half_}}; }
  ShapePtr section() const override {
    const Vec2 corners[4] = {{-bottom_, -half_}, {bottom_, -half_}, {top_, half_}, {-top_, half_}};
    return make_polygon(corners);
  }

 private:
  Real slope() const { return (bottom_ - top_) / (2 * half_); }  // radius lost per metre up

  Real bottom_, top_, half_;  // radii and half the height, m
};

}  // namespace

ShapePtr make_frustum(const char* kind, Real bottom, Real top, Real height) {
  return std::make_shared<Frustum>(kind, bottom, top, height);
}

}  // namespace feder
