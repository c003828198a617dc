// Voronoi marching in the plane, of two convex outlines: the states of V-Clip that a plane has, two corners or a corner
// and an edge. A corner over an edge is the closest one unless a neighbour of it lies lower; then the way down to that
// neighbour ends at it, at an end of the edge, or in the outline. Weak spot: as in space.
#include <limits>

#include "geom/polygon.h"
#include "narrow/march.h"

namespace feder {
namespace {

class FlatMarcher {
 public:
  FlatMarcher(const ConvexPair& pair, const Polygon& a, const Polygon& b) : pair_(pair), side_{a.points(), b.points()} {
    const double reach = length(pair.offset) + a.reach() + b.reach(), size = double(a.size()) + b.size();
    slack_ = kMarchSlack * reach, touch_ = kMarchTouch * size;
  }

  March run(FeaturePair start) {
    return march_on(
        at_, start, touch_, [&] { return step(); }, [&](Gap& gap) { fill(gap); });
  }

 private:
  static Double3 at(const Vec2& p) { return {double(p[0]), double(p[1]), 0}; }
  std::size_t count(int s) const { return side_[s].size(); }
  std::size_t next(int s, std::size_t i) const { return i + 1 < count(s) ? i + 1 : 0; }
  std::size_t last(int s, std::size_t i) const { return i > 0 ? i - 1 : count(s) - 1; }
  Double3 corner(int s, std::size_t i) const {
    const Double3 p = at(side_[s][i]);
    return s == 1 ? pair_.from_b(p) : p;
  }
  MarchVerdict move(int s, Feature::Kind kind, std::size_t index) {
    at_[s] = {kind, static_cast<std::uint16_t>(index)};
    return MarchVerdict::moved;
  }

  // An edge in the frame of a: `d` unit along it, `n` outward.
  struct Edge {
    Double3 tail, d, n;
    double len;
    double along(const Double3& p) const { return dot(p - tail, d); }
    double height(const Double3& p) const { return dot(p - tail, n); }
  };
  Edge edge(int s, std::size_t i) const {
    const Double3 tail = corner(s, i), d = corner(s, next(s, i)) - tail;
    const double len = length(d);
    const Double3 unit = (1 / len) * d;
    return {tail, unit, {unit.y, -unit.x, 0}, len};
  }

  MarchVerdict step() {
    if (at_[0].kind != Feature::vertex && at_[1].kind != Feature::vertex) return move(0, Feature::vertex, at_[0].index);
    if (at_[0].kind == at_[1].kind) return two_corners();
    return corner_edge(at_[0].kind == Feature::vertex ? 0 : 1);
  }

  MarchVerdict two_corners() {
    for (int t = 1; t >= 0; --t) {
      const std::size_t i = at_[t].index;
      const Double3 p = corner(1 - t, at_[1 - t].index), w = corner(t, i);
      const Edge ahead = edge(t, i), behind = edge(t, last(t, i));
      const double forward = dot(p - w, ahead.d), back = -dot(p - w, behind.d);
      if (std::max(forward, back) > slack_) return move(t, Feature::edge, forward >= back ? i : last(t, i));
    }
    return MarchVerdict::closest;
  }

  // The corner is on side s.
  MarchVerdict corner_edge(int s) {
    const int t = 1 - s;
    const std::size_t v = at_[s].index, i = at_[t].index;
    const Edge e = edge(t, i);
    const Double3 p = corner(s, v);
    const double along = e.along(p), height = e.height(p);
    if (along < -slack_) return move(t, Feature::vertex, i);
    if (along > e.len + slack_) return move(t, Feature::vertex, next(t, i));
    if (height <= touch_) return trapped(t, p);

    // the neighbour that the outline falls to most
    std::size_t down = v;
    double steepest = 0;
    for (const std::size_t k : {next(s, v), last(s, v)}) {
      const Double3 q = corner(s, k);
      const double fall = e.height(q) - height;
      if (fall < -slack_ && fall / length(q - p) < steepest) steepest = fall / length(q - p), down = k;
    }
    if (down == v) return MarchVerdict::closest;
    const Double3 q = corner(s, down);
    const double to = e.along(q), low = e.height(q);
    const bool before = to<0, after = to> e.len;
    if (!before && !after) return low <= touch_ ? MarchVerdict::inside : move(s, Feature::vertex, down);
    const double share = ((before ? 0 : e.len) - along) / (to - along);
    if (height + share * (low - height) <= touch_) return MarchVerdict::inside;
    move(t, Feature::vertex, before ? i : next(t, i));
    return move(s, Feature::edge, down == next(s, v) ? v : last(s, v));
  }

  // On the inner side of its edge: on to the highest edge, if the corner is outside at all.
  MarchVerdict trapped(int t, const Double3& p) {
    double highest = touch_;
    std::size_t best = count(t);
    for (std::size_t k = 0; k < count(t); ++k) {
      const double h = edge(t, k).height(p);
      if (h > highest) highest = h, best = k;
    }
    return best < count(t) ? move(t, Feature::edge, best) : MarchVerdict::inside;
  }

  void fill(Gap& gap) const {
    if (at_[0].kind == at_[1].kind) {
      gap.a = corner(0, at_[0].index), gap.b = corner(1, at_[1].index);
      const Double3 d = gap.b - gap.a;
      gap.distance = length(d);
      gap.normal = (gap.distance > 0 ? 1 / gap.distance : 0) * d;
      return;
    }
    const int s = at_[0].kind == Feature::vertex ? 0 : 1;
    const Edge e = edge(1 - s, at_[1 - s].index);
    const Double3 p = corner(s, at_[s].index);
    gap.distance = e.height(p);
    const Double3 on = p - gap.distance * e.n;
    gap.a = s == 0 ? p : on, gap.b = s == 0 ? on : p;
    gap.normal = s == 0 ? -e.n : e.n;
  }

  const ConvexPair& pair_;
  std::span<const Vec2> side_[2];
  Feature at_[2]{};
  double slack_ = 0, touch_ = 0;
};

}  // namespace

March march(const ConvexPair& pair, const Polygon& a, const Polygon& b, FeaturePair start) {
  return FlatMarcher(pair, a, b).run(start);
}

bool within(const Polygon& p, const Feature& feature) {
  return feature.kind <= Feature::edge && feature.index < p.points().size();
}

}  // namespace feder
