// Convex polygon in the plane: Andrew's monotone chain (1979) for the hull, Green's theorem for the moments, strips and
// sectors for the rounding. Weak spot: support points and edges by a walk over all corners.
#include "geom/polygon.h"

#include <algorithm>

#include "feder/error.h"
#include "geom/closest.h"

namespace feder {
namespace {

Real cross2(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

// Area, first and second moments of a piece about its own centre, then moved: m, c, and the tensor of x and y.
struct Moments {
  double area = 0, sx = 0, sy = 0, xx = 0, yy = 0, xy = 0;
  void add(double m, double x, double y, double ixx, double iyy, double ixy) {
    area += m, sx += m * x, sy += m * y;
    xx += ixx + m * x * x, yy += iyy + m * y * y, xy += ixy + m * x * y;
  }
};

// The integrals over triangle (0, p, q).
void add_triangle(Moments& s, const Vec2& p, const Vec2& q) {
  const double a = (double(p[0]) * q[1] - double(p[1]) * q[0]) / 2;
  s.area += a;
  s.sx += a * (double(p[0]) + q[0]) / 3;
  s.sy += a * (double(p[1]) + q[1]) / 3;
  s.xx += a * (double(p[0]) * p[0] + double(q[0]) * q[0] + double(p[0]) * q[0]) / 6;
  s.yy += a * (double(p[1]) * p[1] + double(q[1]) * q[1] + double(p[1]) * q[1]) / 6;
  s.xy += a * (2.0 * p[0] * p[1] + 2.0 * q[0] * q[1] + double(p[0]) * q[1] + double(p[1]) * q[0]) / 12;
}

// The strip of width r along the edge p..q, outside of it.
void add_strip(Moments& s, const Vec2& p, const Vec2& q, const Vec2& n, Real r) {
  const Vec2 e = q - p, c = (p + q + r * n) / 2;
  const double len = e.norm(), m = len * r, along = m * len * len / 12, across = m * double(r) * r / 12;
  const double ux = e[0] / len, uy = e[1] / len;
  s.add(m, c[0], c[1], along * ux * ux + across * n[0] * n[0], along * uy * uy + across * n[1] * n[1],
        along * ux * uy + across * n[0] * n[1]);
}

// The circular sector at corner p between edge normals m and n, cut at the bisector into a symmetric piece.
void add_sector(Moments& s, const Vec2& p, const Vec2& m, const Vec2& n, Real r) {
  const double angle = arc_tan2(cross2(m, n), m.dot(n)) < 0 ? double(kPi) : double(arc_tan2(cross2(m, n), m.dot(n)));
  if (!(angle > 0)) return;
  const Vec2 mid = m + n;
  const double len = mid.norm();
  const double bx = len > 1e-6 ? mid[0] / len : -m[1], by = len > 1e-6 ? mid[1] / len : m[0];
  const double r2 = double(r) * r, area = angle * r2 / 2, sn = sin_cos_sin(angle), half = sin_cos_sin(angle / 2);
  // about the corner, bisector along x: integrals of x, x^2, y^2
  const double first = 2.0 / 3 * r2 * r * half, along = r2 * r2 / 8 * (angle + sn), across = r2 * r2 / 8 * (angle - sn);
  s.area += area;
  s.sx += area * p[0] + first * bx;
  s.sy += area * p[1] + first * by;
  s.xx += area * p[0] * p[0] + 2 * first * bx * p[0] + along * bx * bx + across * by * by;
  s.yy += area * p[1] * p[1] + 2 * first * by * p[1] + along * by * by + across * bx * bx;
  s.xy += area * p[0] * p[1] + first * (bx * p[1] + by * p[0]) + (along - across) * bx * by;
}

}  // namespace

Polygon::Polygon(std::vector<Vec2> points, Real radius) : Shape("polygon", true, radius), points_(std::move(points)) {
  planar_ = true;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec2 e = points_[(i + 1) % points_.size()] - points_[i];
    normals_.push_back(Vec2(e[1], -e[0]) / e.norm());
    reach_ = std::max(reach_, points_[i].norm());
    size_ = std::max(size_, (points_[i] - points_[0]).norm());
  }
}

Aabb Polygon::bounds(const Pose& pose) const {
  Aabb box;
  for (const Vec2& p : points_) box.include(to_world(pose, vec3(p[0], p[1], 0)));
  box.grow(radius_);
  return box;
}

MassProperties Polygon::mass(Real density) const {
  Moments s;
  const std::size_t n = points_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    add_triangle(s, points_[i], points_[j]);
    if (!(radius_ > 0)) continue;
    add_strip(s, points_[i], points_[j], normals_[i], radius_);
    add_sector(s, points_[j], normals_[i], normals_[j], radius_);
  }
  const double cx = s.sx / s.area, cy = s.sy / s.area;
  const double xx = s.xx - s.area * cx * cx, yy = s.yy - s.area * cy * cy, xy = s.xy - s.area * cx * cy;
  MassProperties p{Real(density * s.area), vec3(Real(cx), Real(cy), 0), Mat3::Zero()};
  p.inertia(0, 0) = Real(density * yy);
  p.inertia(1, 1) = Real(density * xx);
  p.inertia(0, 1) = p.inertia(1, 0) = Real(-density * xy);
  p.inertia(2, 2) = Real(density * (xx + yy));
  return p;
}

Real Polygon::extent(const Vec3& c) const {
  Real far = 0;
  for (const Vec2& p : points_) far = std::max(far, length(vec3(p[0], p[1], 0) - c));
  return far + radius_;
}

// Without rounding: clipping against the edges. Rounded: the nearest hit on offset edges and corner circles.
bool Polygon::raycast(const Vec3& o3, const Vec3& d3, RayHit& hit) const {
  const Vec2 o(o3[0], o3[1]), d(d3[0], d3[1]);
  const std::size_t n = points_.size();
  bool inside = true, found = false;
  Real best = Real(1);
  Vec2 normal = Vec2::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 e = points_[(i + 1) % n] - points_[i], from = o - points_[i];
    const Real height = normals_[i].dot(from) - radius_, rise = normals_[i].dot(d);
    inside = inside && normals_[i].dot(from) <= 0;
    const Real along = clamp(from.dot(e) / e.squaredNorm(), 0, 1);
    if ((from - along * e).squaredNorm() <= radius_ * radius_) return hit = {0, Vec3::Zero()}, true;
    if (height > 0 && -rise >= height) {  // the edge, moved out by the radius
      const Real t = height / -rise, at = (from + t * d).dot(e) / e.squaredNorm();
      if (t <= best && at >= 0 && at <= 1) best = t, normal = normals_[i], found = true;
    }
    const Real c = from.squaredNorm() - radius_ * radius_, a = d.squaredNorm(), b = from.dot(d), disc = b * b - a * c;
    if (radius_ > 0 && b < 0 && disc >= 0) {  // the circle at the corner
      const Real t = c / (-b + std::sqrt(disc));
      if (t <= best) best = t, normal = (from + t * d) / radius_, found = true;
    }
  }
  if (inside && n > 2) return hit = {0, Vec3::Zero()}, true;
  if (found) hit = {best, vec3(normal[0], normal[1], 0)};
  return found;
}

Vec3 Polygon::support(const Vec3& d) const {
  std::size_t best = 0;
  Real far = -kInfinity;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Real h = points_[i][0] * d[0] + points_[i][1] * d[1];
    if (h > far) far = h, best = i;
  }
  return vec3(points_[best][0], points_[best][1], 0);
}

int Polygon::face(const Vec3& d, Vec3* points) const {
  std::size_t best = 0;
  Real most = -kInfinity;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Real h = normals_[i][0] * d[0] + normals_[i][1] * d[1];
    if (h > most) most = h, best = i;
  }
  const Vec2 &p = points_[best], &q = points_[(best + 1) % points_.size()];
  points[0] = vec3(p[0], p[1], 0);
  points[1] = vec3(q[0], q[1], 0);
  return 2;
}

// Inside the core: to the nearest edge; outside: from the nearest point of the outline.
Real Polygon::distance(const Vec3& p, Real, Vec3& normal) const {
  const Vec3 q = vec3(p[0], p[1], 0);
  Real highest = -kInfinity, nearest = kInfinity;
  Vec3 face = vec3(0, 1, 0), on = q;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Vec2 &a = points_[i], &b = points_[(i + 1) % points_.size()];
    const Vec3 n = vec3(normals_[i][0], normals_[i][1], 0);
    const Real height = dot(n, q) - normals_[i].dot(a);
    if (height > highest) highest = height, face = n;
    const Vec3 c = closest_on_segment(q, vec3(a[0], a[1], 0), vec3(b[0], b[1], 0));
    const Real d = dot(q - c, q - c);
    if (d < nearest) nearest = d, on = c;
  }
  if (highest <= 0 && points_.size() > 2) {
    normal = face;
    return highest - radius_;
  }
  return round_distance(q - on, radius_, face, normal);
}

ShapeArguments Polygon::arguments() const {
  ShapeArguments out{.sizes = {radius_}};
  for (const Vec2& p : points_) out.points.push_back(vec3(p[0], p[1], 0));
  return out;
}

ShapePtr Polygon::section() const { return std::make_shared<Polygon>(points_, radius_); }

std::vector<Vec2> convex_hull_2d(std::span<const Vec2> points) {
  std::vector<Vec2> p(points.begin(), points.end());
  std::sort(p.begin(), p.end(), [](const Vec2& a, const Vec2& b) { return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1]; });
  p.erase(std::unique(p.begin(), p.end()), p.end());
  if (p.size() < 3) return p;
  Vec2 size = Vec2::Zero();
  for (const Vec2& q : p) size = size.cwiseMax((q - p[0]).cwiseAbs());
  const Real flat = Real(1e-6) * size.maxCoeff() * size.maxCoeff();
  std::vector<Vec2> hull;
  const auto chain = [&](const Vec2& q, std::size_t floor) {
    while (hull.size() > floor && cross2(hull.back() - hull[hull.size() - 2], q - hull.back()) <= flat) hull.pop_back();
    hull.push_back(q);
  };
  for (const Vec2& q : p) chain(q, 1);
  const std::size_t lower = hull.size();
  for (std::size_t i = p.size() - 1; i-- > 0;) chain(p[i], lower);
  hull.pop_back();
  return hull;
}

namespace {

ShapePtr make(const ShapeInput& in) {
  std::vector<Vec2> points;
  for (const Vec3& p : in.points) points.emplace_back(p[0], p[1]);
  const Real radius = in.size(0);
  if (!(radius >= 0) || !std::isfinite(radius))
    throw SceneError("polygon: expected a radius of 0 or more, got " + std::to_string(radius));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i][0]) || !std::isfinite(points[i][1]))
      throw SceneError("polygon: expected finite points, but point " + std::to_string(i + 1) + " is not");
  std::vector<Vec2> hull = convex_hull_2d(points);
  const std::size_t least = radius > 0 ? 2 : 3;
  if (hull.size() < least)
    throw SceneError(
        "polygon: expected at least 3 points with an area (or 2 and a radius), but the convex hull of the " +
        std::to_string(points.size()) + " given has " + std::to_string(hull.size()) + " corners");
  if (hull.size() > kMaxFacePoints)
    throw SceneError("polygon: expected at most " + std::to_string(kMaxFacePoints) + " corners, got " +
                     std::to_string(hull.size()));
  return std::make_shared<Polygon>(std::move(hull), radius);
}

}  // namespace

ShapeKind geom_polygon() {
  return {"polygon",
          "(points, [radius])",
          "2D: the convex hull of a list of {x, y}",
          {.convex = true, .planar = true},
          {{"points", ShapeArgumentType::points_2d}, {"radius", ShapeArgumentType::size, 0}},
          make,
          [] {
            const Vec2 quad[4] = {{-1, -1}, {Real(1.5), -1}, {1, Real(0.5)}, {-1, 1}};
            const Vec2 segment[2] = {{0, Real(-0.5)}, {0, Real(0.5)}};
            const Vec2 small[3] = {{0, 0}, {Real(0.01), 0}, {0, Real(0.01)}};
            return std::vector<ShapePtr>{make_polygon(quad), make_polygon(segment, Real(0.25)),
                                         make_polygon(small, Real(0.002))};
          }};
}

}  // namespace feder
