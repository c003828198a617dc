// Oriented box: axes are the eigenvectors of the covariance of the surface (of triangles, weighted by area, so that
// neither many small ones nor corners inside count more: Gottschalk, Lin & Manocha, "OBBTree", SIGGRAPH 1996), or of
// the points; those of the world where they hold it in less. Fifteen axes separate two of them. Merging: around the
// corners of both, by the axes of either, of the covariance of those corners, or of the world. Tight around what is
// long and askew, for the dearest test but that of hulls. Weak spot: what has no axes of its own in its covariance,
// cubes and square bars: 39 % false pairs where kdop26 has 37 % (tests/README.md).
#include <algorithm>
#include <cmath>

#include "base/double3.h"
#include "bounds/hierarchy_of.h"
#include "bounds/slack.h"

namespace feder {
namespace {

// Of the axes of one in the frame of the other, and of the offset there; parallel axes give no separating cross
// products, so those get a slack. Gottschalk's test.
bool boxes_meet(const Mat3& r, const Vec3& t, const Vec3& a, const Vec3& b) {
  const Mat3 ar = r.cwiseAbs().array() + kVolumeSlack;
  for (int i = 0; i < 3; ++i)
    if (std::abs(t[i]) > a[i] + ar.row(i).dot(b)) return false;
  for (int k = 0; k < 3; ++k)
    if (std::abs(t.dot(r.col(k))) > ar.col(k).dot(a) + b[k]) return false;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      const Real own = a[i1] * ar(i2, k) + a[i2] * ar(i1, k), other = b[k1] * ar(i, k2) + b[k2] * ar(i, k1);
      if (std::abs(t[i2] * r(i1, k) - t[i1] * r(i2, k)) > own + other + slack_of(t)) return false;
    }
  return true;
}

struct ObbVolume {
  Mat3 axes = Mat3::Identity();  // columns
  Vec3 center = Vec3::Zero(), half = Vec3::Zero();

  static ObbVolume along(const Mat3& axes, std::span<const Vec3> points) {
    double lo[3], hi[3];
    Double3 axis[3];
    for (int k = 0; k < 3; ++k) axis[k] = wide(axes.col(k)), lo[k] = 1e300, hi[k] = -1e300;
    for (const Vec3& p : points)
      for (int k = 0; k < 3; ++k) {
        const double s = dot(axis[k], wide(p));
        lo[k] = std::min(lo[k], s), hi[k] = std::max(hi[k], s);
      }
    ObbVolume v;
    v.axes = axes;
    Double3 c{0, 0, 0};
    for (int k = 0; k < 3; ++k) c = c + (lo[k] + hi[k]) / 2 * axis[k];
    v.center = narrow(c);
    for (int k = 0; k < 3; ++k) v.half[k] = static_cast<Real>((hi[k] - lo[k]) / 2);
    const Real longest = v.half.maxCoeff();
    for (int k = 0; k < 3; ++k) v.half[k] += kVolumeSlack * longest + slack_of(v.center);
    return v;
  }
  static ObbVolume smaller(const ObbVolume& a, const ObbVolume& b) { return b.cost() < a.cost() ? b : a; }

  static ObbVolume around(std::span<const Vec3> points, bool triangles) {
    return smaller(along(main_axes(points, triangles), points), along(Mat3::Identity(), points));
  }
  static ObbVolume joined(const ObbVolume& a, const ObbVolume& b) {
    Vec3 corners[16];
    for (unsigned k = 0; k < 8; ++k) corners[k] = a.corner(k), corners[8 + k] = b.corner(k);
    const ObbVolume one = smaller(along(a.axes, corners), along(b.axes, corners));
    return smaller(one, around(corners, false));
  }
  Vec3 corner(unsigned k) const {
    Vec3 c = center;
    for (int i = 0; i < 3; ++i) c += (k >> i & 1 ? half[i] : -half[i]) * axes.col(i);
    return c;
  }
  // Of the covariance of the points about their mean, or of the surface of the triangles about its own.
  static Mat3 main_axes(std::span<const Vec3> points, bool triangles) {
    Double3 mean{0, 0, 0};
    double sum[3][3] = {}, weight = 0;
    const auto add = [&](const Double3& p, double w) {
      const double q[3] = {p.x, p.y, p.z};
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) sum[i][k] += w * q[i] * q[k];
    };
    const Double3 origin = wide(points[0]);
    if (triangles)
      for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
        const Double3 a = wide(points[i]) - origin, b = wide(points[i + 1]) - origin, c = wide(points[i + 2]) - origin;
        const double area = length(cross(b - a, c - a)) / 2;
        add(a, area / 12), add(b, area / 12), add(c, area / 12), add(a + b + c, area / 12);
        mean = mean + area / 3 * (a + b + c), weight += area;
      }
    if (!(weight > 0)) {
      mean = {0, 0, 0}, weight = 0;
      for (auto& row : sum) std::fill(row, row + 3, 0.0);
      for (const Vec3& p : points) add(wide(p) - origin, 1), mean = mean + (wide(p) - origin), weight += 1;
    }
    const double m[3] = {mean.x / weight, mean.y / weight, mean.z / weight};
    double most = 0;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        sum[i][k] = sum[i][k] / weight - m[i] * m[k], most = std::max(most, std::abs(sum[i][k]));
    if (!(most > 0)) return Mat3::Identity();
    Mat3 c, vectors;
    Vec3 values;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) c(i, k) = static_cast<Real>(sum[i][k] / most);
    eigen_symmetric(c, values, vectors);
    return vectors;
  }

  bool contains(const Vec3& p) const {
    const Vec3 local = axes.transpose() * (p - center);
    return (local.cwiseAbs().array() <= half.array()).all();
  }
  bool overlaps(const ObbVolume& o) const {
    return boxes_meet(axes.transpose() * o.axes, axes.transpose() * (o.center - center), half, o.half);
  }
  bool meets(const Aabb& box) const {
    if (!is_finite(box.lo) || !is_finite(box.hi)) {  // half of space: by its corners
      Aabb own;
      for (unsigned k = 0; k < 8; ++k) own.include(corner(k));
      return feder::overlaps(own, box);
    }
    const Vec3 size = Real(0.5) * (box.hi - box.lo), at = box.lo + size;
    if ((size.array() < 0).any()) return false;
    return boxes_meet(axes, center - at, Vec3(size.array() + slack_of(at)), half);
  }
  bool meets_ray(const Vec3& origin, const Vec3& ray) const {
    Real first = 0, last = 1;
    const Vec3 o = axes.transpose() * (origin - center), d = axes.transpose() * ray;
    const Real slack = slack_of(Vec3(origin - center)) + slack_of(ray);
    for (int k = 0; k < 3; ++k) {
      const Real size = half[k] + slack;
      if (std::abs(d[k]) <= slack) {
        if (std::abs(o[k]) > size + slack) return false;
        continue;
      }
      const Real a = (-size - o[k]) / d[k], b = (size - o[k]) / d[k];
      first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
    }
    return first <= last + kVolumeSlack;
  }
  double cost() const {
    const double x = static_cast<double>(half[0]), y = static_cast<double>(half[1]), z = static_cast<double>(half[2]);
    return 4 * (x * y + y * z + z * x);
  }
  double volume() const {
    return 8 * static_cast<double>(half[0]) * static_cast<double>(half[1]) * static_cast<double>(half[2]);
  }
  bool edges(EdgeVisitor visit) const {
    Mat3 half_axes;
    for (int k = 0; k < 3; ++k) half_axes.col(k) = half[k] * axes.col(k);
    return edges_of_box(center, half_axes, visit);
  }
};

}  // namespace

VolumeKind bounds_obb() { return volume_kind<ObbVolume>("obb", "oriented box: tight around what is long and askew"); }

}  // namespace feder
