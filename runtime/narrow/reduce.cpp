// Reduction of a contact patch to four points: the deepest, the farthest from it, and the two that span most area on
// either side (Moravanszky and Terdiman, "Fast Contact Reduction for Dynamics Simulation", Game Programming Gems 4,
// 2004). Keeps nothing between calls. Weak spot: greedy, so the four need not be the largest quadrilateral.
#include "narrow/reduce.h"

#include <bit>

namespace feder {
namespace {

// Relative to the size of the patch: how much deeper a later point must be to be called the deepest.
constexpr Real kSameDepth = Real(2e-5);

Real area(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& n) { return dot(cross(b - a, c - a), n); }

}  // namespace

int reduce_indices(std::span<const ManifoldPoint> p, const Vec3& normal, int* chosen) {
  const int count = static_cast<int>(p.size());
  if (count <= kMaxManifoldPoints) {
    for (int i = 0; i < count; ++i) chosen[i] = i;
    return count;
  }
  Real size = 0;
  for (int i = 1; i < count; ++i) size = std::max(size, (p[i].position - p[0].position).cwiseAbs().maxCoeff());
  int a = 0;
  for (int i = 1; i < count; ++i)
    if (p[i].separation < p[a].separation - kSameDepth * size) a = i;

  // the farthest from the deepest, then the two that stick out most on either side of that line
  int b = a, c = a, d = a;
  Real best = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 e = p[i].position - p[a].position;
    const Real far = dot(e, e);
    if (far > best) best = far, b = i;
  }
  Real left = 0, right = 0;
  for (int i = 0; i < count; ++i) {
    const Real s = area(p[a].position, p[b].position, p[i].position, normal);
    if (s > left) left = s, c = i;
    if (s < right) right = s, d = i;
  }
  // all on one side: the fourth is the one farthest outside the triangle's other two edges
  if (c == a || d == a) {
    const int third = c == a ? d : c;
    const Real sign = c == a ? Real(-1) : Real(1);
    int fourth = a;
    Real out = 0;
    if (third != a) {
      for (int i = 0; i < count; ++i) {
        const Real s = std::min(sign * area(p[b].position, p[third].position, p[i].position, normal),
                                sign * area(p[third].position, p[a].position, p[i].position, normal));
        if (s < out) out = s, fourth = i;
      }
    }
    c = third, d = fourth;
  }
  int n = 0;
  for (int i = 0; i < count; ++i)
    if (i == a || i == b || i == c || i == d) chosen[n++] = i;
  return n;
}

void reduce_points(std::span<const ManifoldPoint> points, const Vec3& normal, Manifold& out) {
  int chosen[kMaxManifoldPoints];
  out.normal = normal;
  out.count = reduce_indices(points, normal, chosen);
  for (int i = 0; i < out.count; ++i) out.points[i] = points[chosen[i]];
}

std::uint32_t feature_of(const Vec3& local) {
  std::uint32_t h = 2166136261u;
  for (int i = 0; i < 3; ++i) h = (h ^ std::bit_cast<std::uint32_t>(static_cast<float>(local[i]))) * 16777619u;
  return h ^ h >> 15;
}

}  // namespace feder
