// Convex hull (quickhull.cpp). Two are apart where the normal of a face of either, or the product of an edge of each,
// separates them. The tightest volume of all, and by far the dearest.
// What is flat gets a thickness of 4e-4 of its size; what has more than kMaxHullCorners is bounded by its box; of two
// whose edges make more than kMostProducts, only faces are tried (it may then find what does not touch).
#include <algorithm>
#include <cmath>

#include "base/double3.h"
#include "bounds/hierarchy_of.h"
#include "bounds/polytope.h"
#include "bounds/quickhull.h"
#include "bounds/slack.h"
#include "feder/error.h"

namespace feder {
namespace {

constexpr double kThickness = 2e-4;  // of the size, on either side; quickhull refuses less than half of that
constexpr std::size_t kMostProducts = 4096;

// What the test of separating axes knows of a body.
struct Faceted {
  std::vector<Double3> corners, normals, edges;
};

void span_along(const std::vector<Double3>& corners, const Double3& axis, double& lo, double& hi) {
  lo = 1e300, hi = -1e300;
  for (const Double3& c : corners) {
    const double s = dot(axis, c);
    lo = std::min(lo, s), hi = std::max(hi, s);
  }
}

bool separates(const Double3& axis, const Faceted& a, const Faceted& b, double slack) {
  double alo, ahi, blo, bhi;
  span_along(a.corners, axis, alo, ahi), span_along(b.corners, axis, blo, bhi);
  const double most = slack * length(axis);
  return ahi + most < blo || bhi + most < alo;
}

bool faceted_meet(const Faceted& a, const Faceted& b, double slack) {
  for (const Faceted* f : {&a, &b})
    for (const Double3& n : f->normals)
      if (separates(n, a, b, slack)) return false;
  if (a.edges.size() * b.edges.size() > kMostProducts) return true;
  for (const Double3& e : a.edges)
    for (const Double3& g : b.edges) {
      const Double3 axis = cross(e, g);
      if (dot(axis, axis) > 1e-12 && separates(axis, a, b, slack)) return false;
    }
  return true;
}

Faceted faceted_box(const Aabb& box) {
  Faceted f;
  for (unsigned k = 0; k < 8; ++k)
    f.corners.push_back(
        wide(Vec3(k & 1 ? box.hi[0] : box.lo[0], k & 2 ? box.hi[1] : box.lo[1], k & 4 ? box.hi[2] : box.lo[2])));
  f.normals = f.edges = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return f;
}

struct HullVolume {
  Faceted body;
  std::vector<double> offsets;  // by normal: of its plane
  Aabb box;
  double held = 0, surface = 0;  // m^3, m^2
  double slack = 0;              // m

  static HullVolume around(std::span<const Vec3> points, bool) {
    HullVolume v;
    for (const Vec3& p : points) v.box.include(p);
    const Vec3 d = v.box.hi - v.box.lo;
    const double size = static_cast<double>(d.maxCoeff());
    v.slack = static_cast<double>(kVolumeSlack) *
              (size + static_cast<double>(v.box.lo.cwiseAbs().maxCoeff() + v.box.hi.cwiseAbs().maxCoeff()));
    try {
      if (points.size() >= 4) return v.take(build_hull(points)), v;
    } catch (const SceneError&) {  // flat, or round
    }
    std::vector<Vec3> thick;
    const auto by = static_cast<Real>(std::max(kThickness * size, v.slack));
    for (const Vec3& p : points)
      for (int k = 0; k < 3; ++k) thick.push_back(p + by * Vec3::Unit(k)), thick.push_back(p - by * Vec3::Unit(k));
    try {
      v.take(build_hull(thick));
    } catch (const SceneError&) {
      v.take_box();
    }
    return v;
  }
  static HullVolume joined(const HullVolume& a, const HullVolume& b) {
    std::vector<Vec3> corners;
    for (const HullVolume* v : {&a, &b})
      for (const Double3& c : v->body.corners) corners.push_back(narrow(c));
    HullVolume v = around(corners, false);
    v.slack = std::max({v.slack, a.slack, b.slack}) * 2;
    return v;
  }
  void take(const HullData& hull) {
    for (const Vec3& c : hull.corners) body.corners.push_back(wide(c)), box.include(c);
    const Double3 inner = body.corners[0];
    const auto add_edge = [this](const Double3& e) {
      const double n = length(e);
      if (!(n > 0)) return;
      const Double3 unit = 1 / n * e;
      for (const Double3& known : body.edges) {
        const Double3 turn = cross(known, unit);
        if (dot(turn, turn) < 1e-10) return;
      }
      body.edges.push_back(unit);
    };
    for (const HullFace& f : hull.faces) {
      body.normals.push_back(wide(f.normal)), offsets.push_back(static_cast<double>(f.offset));
      const Double3 a = wide(hull.corner(f, 0));
      for (int i = 0; i < f.count; ++i) add_edge(wide(hull.corner(f, (i + 1) % f.count)) - wide(hull.corner(f, i)));
      for (int i = 2; i < f.count; ++i) {
        const Double3 n = cross(wide(hull.corner(f, i - 1)) - a, wide(hull.corner(f, i)) - a);
        surface += length(n) / 2, held += dot(n, a - inner) / 6;
      }
    }
  }
  void take_box() {
    body = faceted_box(box);
    for (int k = 0; k < 3; ++k) offsets.push_back(static_cast<double>(box.hi[k]));
    for (int k = 0; k < 3; ++k)
      body.normals.push_back(-body.normals[static_cast<std::size_t>(k)]),
          offsets.push_back(-static_cast<double>(box.lo[k]));
    const Vec3 d = box.hi - box.lo;
    held = static_cast<double>(d[0]) * static_cast<double>(d[1]) * static_cast<double>(d[2]);
    surface = 2 * half_surface(box);
  }

  bool contains(const Vec3& p) const {
    for (std::size_t k = 0; k < offsets.size(); ++k)
      if (dot(body.normals[k], wide(p)) > offsets[k] + thin()) return false;
    return true;
  }
  bool overlaps(const HullVolume& o) const {
    return feder::overlaps(box, o.box) && faceted_meet(body, o.body, slack + o.slack + thin() + o.thin());
  }
  bool meets(const Aabb& other) const {
    if (!feder::overlaps(box, other)) return false;
    Aabb near{other.lo.cwiseMax(box.lo), other.hi.cwiseMin(box.hi)};  // of a large one: the part that may matter
    near.grow(static_cast<Real>(slack));
    return faceted_meet(body, faceted_box(near), slack + thin());
  }
  bool meets_ray(const Vec3& origin, const Vec3& ray) const {
    double first = 0, last = 1;
    const double room = thin() + slack + static_cast<double>(slack_of(origin) + slack_of(ray));
    for (std::size_t k = 0; k < offsets.size(); ++k) {
      const double at = offsets[k] + room - dot(body.normals[k], wide(origin)), by = dot(body.normals[k], wide(ray));
      if (by > 0)
        last = std::min(last, at / by);
      else if (by < 0)
        first = std::max(first, at / by);
      else if (at < 0)
        return false;
    }
    return first <= last + static_cast<double>(kVolumeSlack);
  }
  // Quickhull leaves out what lies so near to a face.
  double thin() const { return 4e-5 * static_cast<double>((box.hi - box.lo).maxCoeff()) + slack; }
  double cost() const { return surface / 2; }
  double volume() const { return held; }
  bool edges(EdgeVisitor visit) const {
    std::vector<HalfSpace> planes;
    double size = 0;
    for (std::size_t k = 0; k < offsets.size(); ++k) planes.push_back({body.normals[k], offsets[k]});
    for (const Double3& c : body.corners) size = std::max(size, length(c));
    return edges_within(planes, size, visit);
  }
};

}  // namespace

VolumeKind bounds_hull() { return volume_kind<HullVolume>("hull", "convex hull: tightest, and dearest"); }

}  // namespace feder
