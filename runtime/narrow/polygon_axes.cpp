// Depth of two overlapping outlines: separating axes over the edge normals of both (Ericson, "Real-Time Collision
// Detection", 2005, 5.2.1). Weak spot: every edge asks for a support point of the other, so it costs the product of the
// corners.
#include "narrow/polygon_axes.h"

namespace feder {
namespace {

constexpr double kPreference = 1e-3;  // of the size: how much better an edge of b must be than one of a

// The edge of `own` with the largest gap to the other core.
template <class Support>
Gap best_edge(const Polygon& own, const Support& lowest) {
  Gap best;
  best.distance = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < own.points().size(); ++i) {
    const Vec2 &p = own.points()[i], &m = own.normals()[i];
    const Double3 n{m[0], m[1], 0}, at{p[0], p[1], 0}, other = lowest(n);
    const double gap = dot(n, other - at);
    if (gap > best.distance) best = {gap, other - gap * n, other, n};
  }
  return best;
}

}  // namespace

Gap polygon_overlap(const ConvexPair& pair, const Polygon& a, const Polygon& b) {
  const Gap ga = best_edge(
      a, [&](const Double3& n) { return pair.from_b(wide(pair.b.support(narrow(pair.direction_to_b(-n))))); });
  const Gap gb = best_edge(b, [&](const Double3& n) {  // in the frame of b
    const Double3 in_a = pair.from_b(n) - pair.offset, s = wide(pair.a.support(narrow(-in_a))) - pair.offset;
    return pair.direction_to_b(s);
  });
  const double size = std::max(a.extent(Vec3::Zero()), b.extent(Vec3::Zero()));
  if (gb.distance <= ga.distance + kPreference * size) return ga;
  return {gb.distance, pair.from_b(gb.b), pair.from_b(gb.a), pair.offset - pair.from_b(gb.normal)};
}

}  // namespace feder
