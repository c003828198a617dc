// Convex hull as a shape: second moments over tetrahedra (Tonon 2004), rays clipped by the faces (Cyrus and Beck 1978).
// Weak spot: support points and faces by a walk over all of them, eight at a time, linear in their number.
#include "geom/hull.h"

#include "geom/closest.h"
#include "geom/point_groups.h"

namespace feder {

Hull::Hull(HullData data, std::span<const Vec3> points)
    : Shape("hull", true), data_(std::move(data)),
      corner_lanes_(grouped(data_.corners.size(), [&](std::size_t i) -> const Vec3& { return data_.corners[i]; })),
      normal_lanes_(grouped(data_.faces.size(), [&](std::size_t i) -> const Vec3& { return data_.faces[i].normal; })),
      kernel_(point_kernel()), points_(points.begin(), points.end()) {}

Aabb Hull::bounds(const Pose& pose) const { return bounds_of(corner_lanes_, pose); }

// Second moments over tetrahedra from an inner point to the triangles of the faces (Tonon 2004), as the covariance C
// about the centre of mass: I = tr(C) 1 - C.
MassProperties Hull::mass(Real density) const {
  using Sum = double;
  Vec3 inner = Vec3::Zero();
  for (const Vec3& c : data_.corners) inner += c / Real(data_.corners.size());
  Sum volume = 0, first[3] = {0, 0, 0}, second[3][3] = {};
  for (const HullFace& f : data_.faces) {
    for (int k = 2; k < f.count; ++k) {
      const Vec3 p[3] = {data_.corner(f, 0) - inner, data_.corner(f, k - 1) - inner, data_.corner(f, k) - inner};
      const Vec3 s = p[0] + p[1] + p[2];
      const Sum v = Sum(dot(p[0], cross(p[1], p[2]))) / 6;
      volume += v;
      for (int i = 0; i < 3; ++i) {
        first[i] += v / 4 * s[i];
        for (int j = 0; j < 3; ++j) {
          Sum sum = Sum(s[i]) * s[j];
          for (const Vec3& q : p) sum += Sum(q[i]) * q[j];
          second[i][j] += v / 20 * sum;
        }
      }
    }
  }
  Vec3 center;
  for (int i = 0; i < 3; ++i) center[i] = Real(first[i] / volume);
  Sum c[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c[i][j] = density * (second[i][j] - first[i] * first[j] / volume);
  MassProperties m{Real(density * volume), inner + center, Mat3::Zero()};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.inertia(i, j) = Real((i == j ? c[0][0] + c[1][1] + c[2][2] : 0) - c[i][j]);
  return m;
}

Real Hull::extent(const Vec3& center) const {
  Real far = 0;
  for (const Vec3& c : data_.corners) far = std::max(far, length(c - center));
  return far;
}

// Clips the ray by every face (Cyrus and Beck 1978).
bool Hull::raycast(const Vec3& o, const Vec3& d, RayHit& hit) const {
  Real enter = 0, leave = 1;
  const HullFace* by = nullptr;
  for (const HullFace& f : data_.faces) {
    const Real height = dot(f.normal, o) - f.offset, rise = dot(f.normal, d);
    if (rise == 0) {
      if (height > 0) return false;
      continue;
    }
    const Real t = -height / rise;
    if (rise < 0 && t > enter) enter = t, by = &f;
    if (rise > 0 && t < leave) leave = t;
    if (enter > leave) return false;
  }
  hit = {enter, by ? by->normal : Vec3(Vec3::Zero())};
  return true;
}

Vec3 Hull::support(const Vec3& d) const {
  return data_.corners[kernel_->farthest(corner_lanes_.data(), groups_in(corner_lanes_), d[0], d[1], d[2])];
}

int Hull::face(const Vec3& d, Vec3* points) const {
  const HullFace* best =
      &data_.faces[kernel_->farthest(normal_lanes_.data(), groups_in(normal_lanes_), d[0], d[1], d[2])];
  // rounder faces give evenly chosen corners
  const int count = std::min<int>(best->count, kMaxFacePoints);
  for (int i = 0; i < count; ++i) points[i] = data_.corner(*best, i * best->count / count);
  return count;
}

// Inside: to the nearest face. Outside: the nearest point lies on a face that sees p.
Real Hull::distance(const Vec3& p, Real limit, Vec3& normal) const {
  Real highest = -kInfinity;
  for (const HullFace& f : data_.faces) {
    const Real height = dot(f.normal, p) - f.offset;
    if (height > highest) highest = height, normal = f.normal;
  }
  if (highest <= 0 || highest >= limit) return highest;
  Real best = kInfinity;
  for (const HullFace& f : data_.faces) {
    const Real height = dot(f.normal, p) - f.offset;
    if (!(height > 0)) continue;
    Vec3 on = p - height * f.normal;
    bool beyond = false;
    Vec3 edge = on;
    Real nearest = kInfinity;
    for (int i = 0; i < f.count; ++i) {
      const Vec3 &a = data_.corner(f, i), &b = data_.corner(f, (i + 1) % f.count);
      if (dot(cross(b - a, on - a), f.normal) >= 0) continue;
      beyond = true;
      const Vec3 c = closest_on_segment(p, a, b);
      const Real d = dot(p - c, p - c);
      if (d < nearest) nearest = d, edge = c;
    }
    if (beyond) on = edge;
    const Real d = length(p - on);
    if (!(d < best)) continue;
    best = d;
    normal = normalized_or(p - on, f.normal);
  }
  return best;
}

// The outline of the projection to the xy plane.
ShapePtr Hull::section() const {
  std::vector<Vec2> flat;
  for (const Vec3& c : data_.corners) flat.push_back(Vec2(c[0], c[1]));
  return make_polygon(flat);
}

ShapeKind geom_hull() {
  return {"hull",
          "(points)",
          "the convex hull of a list of {x, y, z} or a buffer",
          {.convex = true},
          {{"points", ShapeArgumentType::points}},
          [](const ShapeInput& in) -> ShapePtr { return std::make_shared<Hull>(build_hull(in.points), in.points); },
          [] {
            const Vec3 wedge[6] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {-1, 1, -1}, {-1, 1, 1}};
            const Vec3 tetra[4] = {{0, 0, 0}, {Real(0.01), 0, 0}, {0, Real(0.02), 0}, {0, 0, Real(0.01)}};
            // a flat octahedron with a point inside
            const Vec3 gem[7] = {{1, 0, 0}, {-1, 0, 0}, {0, Real(0.2), 0}, {0, Real(-0.2), 0},
                                 {0, 0, 1}, {0, 0, -1}, {Real(0.1), 0, 0}};
            return std::vector<ShapePtr>{make_hull(wedge), make_hull(tetra), make_hull(gem)};
          },
          true};
}

}  // namespace feder
