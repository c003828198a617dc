// k-DOPs: slabs along k/2 fixed directions, those of the axes, corners (14), edges (18) or both (26) of a cube
// (Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs", TVCG 1998). Tests of
// k comparisons, merged and refitted without loss. Weak spot: two of them that a direction of neither would separate
// count as touching.
#include <algorithm>
#include <cmath>

#include "bounds/hierarchy_of.h"
#include "bounds/polytope.h"
#include "bounds/slack.h"

namespace feder {
namespace {

constexpr int kDirections[13][3] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 1},  {1, 1, -1}, {1, -1, 1}, {1, -1, -1},
                                    {1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}, {0, 1, 1},  {0, 1, -1}};

template <int kSides>
struct KdopVolume {
  static constexpr int kCount = kSides / 2;
  Real lo[kCount], hi[kCount];

  // The axes, then the corners' directions but for 18, then the edges'.
  static const int* direction(int k) { return kDirections[k >= 3 && kSides == 18 ? k + 4 : k]; }
  static Real along(int k, const Vec3& p) {
    const int* d = direction(k);
    return static_cast<Real>(d[0]) * p[0] + static_cast<Real>(d[1]) * p[1] + static_cast<Real>(d[2]) * p[2];
  }
  static KdopVolume around(std::span<const Vec3> points, bool) {
    KdopVolume v;
    std::fill(v.lo, v.lo + kCount, kInfinity), std::fill(v.hi, v.hi + kCount, -kInfinity);
    for (const Vec3& p : points)
      for (int k = 0; k < kCount; ++k) {
        const Real s = along(k, p), slack = k < 3 ? Real(0) : slack_of(p);
        v.lo[k] = std::min(v.lo[k], s - slack), v.hi[k] = std::max(v.hi[k], s + slack);
      }
    return v;
  }
  static KdopVolume joined(const KdopVolume& a, const KdopVolume& b) {
    KdopVolume v;
    for (int k = 0; k < kCount; ++k) v.lo[k] = std::min(a.lo[k], b.lo[k]), v.hi[k] = std::max(a.hi[k], b.hi[k]);
    return v;
  }
  bool contains(const Vec3& p) const {
    for (int k = 0; k < kCount; ++k)
      if (!(lo[k] <= along(k, p) && along(k, p) <= hi[k])) return false;
    return true;
  }
  bool overlaps(const KdopVolume& o) const {
    for (int k = 0; k < kCount; ++k)
      if (!(lo[k] <= o.hi[k] && o.lo[k] <= hi[k])) return false;
    return true;
  }
  bool meets(const Aabb& box) const {
    if (!feder::overlaps(Aabb{Vec3(lo[0], lo[1], lo[2]), Vec3(hi[0], hi[1], hi[2])}, box)) return false;
    if (!is_finite(box.lo) || !is_finite(box.hi)) return true;
    const Real slack = slack_of(box.lo) + slack_of(box.hi);
    for (int k = 3; k < kCount; ++k) {
      const int* d = direction(k);
      Real from = -slack, to = slack;
      for (int i = 0; i < 3; ++i) {
        from += d[i] == 0 ? Real(0) : d[i] > 0 ? box.lo[i] : -box.hi[i];
        to += d[i] == 0 ? Real(0) : d[i] > 0 ? box.hi[i] : -box.lo[i];
      }
      if (!(lo[k] <= to && from <= hi[k])) return false;
    }
    return true;
  }
  bool meets_ray(const Vec3& origin, const Vec3& ray) const {
    Real first = 0, last = 1;
    const Real slack = slack_of(origin) + slack_of(ray);
    for (int k = 0; k < kCount; ++k) {
      const Real o = along(k, origin), d = along(k, ray), from = lo[k] - slack, to = hi[k] + slack;
      if (std::abs(d) <= slack) {
        if (o < from - slack || o > to + slack) return false;
        continue;
      }
      const Real a = (from - o) / d, b = (to - o) / d;
      first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
    }
    return first <= last + kVolumeSlack;
  }
  // Of its box, in the share that its corners leave: the mean of width over that of the box along each direction.
  double cost() const {
    const double x = static_cast<double>(hi[0] - lo[0]), y = static_cast<double>(hi[1] - lo[1]),
                 z = static_cast<double>(hi[2] - lo[2]);
    double share = 0;
    for (int k = 3; k < kCount; ++k) {
      const int* d = direction(k);
      const double whole = std::abs(d[0]) * x + std::abs(d[1]) * y + std::abs(d[2]) * z;
      share += whole > 0 ? std::min(1.0, static_cast<double>(hi[k] - lo[k]) / whole) : 1;
    }
    return (x * y + y * z + z * x) * share / (kCount - 3);
  }
  double volume() const {
    double size;
    const std::vector<HalfSpace> planes = half_spaces(size);
    return volume_within(planes, size);
  }
  bool edges(EdgeVisitor visit) const {
    double size;
    const std::vector<HalfSpace> planes = half_spaces(size);
    return edges_within(planes, size, visit);
  }
  std::vector<HalfSpace> half_spaces(double& size) const {
    std::vector<HalfSpace> planes;
    size = 0;
    for (int k = 0; k < kCount; ++k) {
      const int* d = direction(k);
      const Double3 n{double(d[0]), double(d[1]), double(d[2])};
      planes.push_back({n, static_cast<double>(hi[k])}), planes.push_back({-n, -static_cast<double>(lo[k])});
      if (k < 3) size += std::max(std::abs(static_cast<double>(lo[k])), std::abs(static_cast<double>(hi[k])));
    }
    return planes;
  }
};

}  // namespace

VolumeKind bounds_kdop14() { return volume_kind<KdopVolume<14>>("kdop14", "box with its corners cut off"); }
VolumeKind bounds_kdop18() { return volume_kind<KdopVolume<18>>("kdop18", "box with its edges cut off"); }
VolumeKind bounds_kdop26() { return volume_kind<KdopVolume<26>>("kdop26", "box with corners and edges cut off"); }

}  // namespace feder
