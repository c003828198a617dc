// Smallest enclosing sphere, exact: points on the sphere are found by trying each against the sphere of those before
// it, in random order, and moving those that lie outside to the front (Welzl 1991; Gaertner 1999), in double.
// Merging: the smallest sphere of two. The cheapest test and refit; loose around what is long.
#include <algorithm>
#include <cmath>

#include "base/double3.h"
#include "base/rng.h"
#include "bounds/hierarchy_of.h"
#include "bounds/slack.h"

namespace feder {
namespace {

struct Ball {
  Double3 center{0, 0, 0};
  double square = -1;  // of the radius; below 0: of no points
  bool holds(const Double3& p) const {
    const Double3 d = p - center;
    return dot(d, d) <= square * (1 + 1e-12);
  }
};

// Through up to four points; those that do not determine one are left out.
Ball through(const std::vector<Double3>& on) {
  if (on.empty()) return {};
  // center = p0 + sum l_i q_i with |center - p_i| equal: Gram matrix of the q
  const std::size_t n = on.size() - 1;
  Double3 q[3];
  double a[3][4];
  for (std::size_t i = 0; i < n; ++i) q[i] = on[i + 1] - on[0];
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) a[i][k] = 2 * dot(q[i], q[k]);
    a[i][3] = dot(q[i], q[i]);
  }
  double l[3] = {0, 0, 0};
  std::size_t pivot[3] = {0, 1, 2};
  for (std::size_t c = 0; c < n; ++c) {  // elimination with pivots; a vanishing one: the point adds nothing
    std::size_t best = c;
    for (std::size_t r = c; r < n; ++r)
      if (std::abs(a[r][c]) > std::abs(a[best][c])) best = r;
    std::swap(a[c], a[best]);
    if (!(std::abs(a[c][c]) > 1e-14 * a[c][3])) return through({on.begin(), on.end() - 1});
    for (std::size_t r = c + 1; r < n; ++r) {
      const double f = a[r][c] / a[c][c];
      for (std::size_t k = c; k < n; ++k) a[r][k] -= f * a[c][k];
      a[r][3] -= f * a[c][3];
    }
  }
  for (std::size_t c = n; c-- > 0;) {
    double sum = a[c][3];
    for (std::size_t k = c + 1; k < n; ++k) sum -= a[c][k] * l[k];
    l[pivot[c]] = sum / a[c][c];
  }
  Double3 to{0, 0, 0};
  for (std::size_t i = 0; i < n; ++i) to = to + l[i] * q[i];
  return {on[0] + to, dot(to, to)};
}

Ball smallest_with(std::vector<Double3>& points, std::size_t count, std::vector<Double3>& on) {
  Ball ball = through(on);
  if (on.size() == 4) return ball;
  for (std::size_t i = 0; i < count; ++i) {
    if (ball.square >= 0 && ball.holds(points[i])) continue;
    const Double3 p = points[i];
    on.push_back(p);
    ball = smallest_with(points, i, on);
    on.pop_back();
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(i),
                points.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
  return ball;
}

struct SphereVolume {
  Vec3 center = Vec3::Zero();
  Real radius = 0;

  static SphereVolume around(std::span<const Vec3> points, bool) {
    std::vector<Double3> list;
    for (const Vec3& p : points) list.push_back(wide(p));
    Rng rng(7);
    for (std::size_t k = list.size(); k > 1; --k) std::swap(list[k - 1], list[rng.next() % k]);
    std::vector<Double3> on;
    const Ball ball = smallest_with(list, list.size(), on);
    SphereVolume s;
    s.center = narrow(ball.center);
    double far = 0;  // from the rounded center
    for (const Vec3& p : points) far = std::max(far, length(wide(p) - wide(s.center)));
    s.radius = loosened(static_cast<Real>(far), s.center);
    return s;
  }
  static SphereVolume joined(const SphereVolume& a, const SphereVolume& b) {
    const Double3 to = wide(b.center) - wide(a.center);
    const double d = length(to), ra = static_cast<double>(a.radius), rb = static_cast<double>(b.radius);
    if (d + rb <= ra) return a;
    if (d + ra <= rb) return b;
    SphereVolume s;
    const double r = (d + ra + rb) / 2;
    s.center = narrow(wide(a.center) + ((r - ra) / d) * to);
    s.radius = loosened(static_cast<Real>(r), s.center);
    return s;
  }
  bool contains(const Vec3& p) const { return length(p - center) <= radius; }
  bool overlaps(const SphereVolume& o) const {
    const Vec3 d = o.center - center;
    const Real r = radius + o.radius;
    return dot(d, d) <= r * r;
  }
  bool meets(const Aabb& box) const {
    const Vec3 d = center - center.cwiseMax(box.lo).cwiseMin(box.hi);
    return dot(d, d) <= radius * radius;
  }
  bool meets_ray(const Vec3& origin, const Vec3& ray) const {
    const Vec3 to = center - origin;
    const Real square = dot(ray, ray), t = square > 0 ? clamp(dot(to, ray) / square, 0, 1) : Real(0);
    return length(Vec3(to - t * ray)) <= radius + slack_of(to);
  }
  double cost() const { return static_cast<double>(radius * radius); }
  double volume() const { return 4 * 3.14159265358979323846 / 3 * std::pow(static_cast<double>(radius), 3); }
  bool edges(EdgeVisitor visit) const { return edges_of_ball(center, radius, visit); }
};

}  // namespace

VolumeKind bounds_sphere() { return volume_kind<SphereVolume>("sphere", "smallest sphere: cheapest test and refit"); }

}  // namespace feder
