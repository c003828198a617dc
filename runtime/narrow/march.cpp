// Voronoi marching in space: V-Clip (Mirtich, "V-Clip: fast and robust polyhedral collision detection", ACM Trans.
// Graphics 17, 1998; after Lin & Canny 1991). Two features are the closest ones when each lies, at the closest points,
// in the Voronoi region of the other. A pair that is not moves to the neighbour whose region was entered: an edge is
// clipped against the planes between regions, and where it leaves them the sign of the distance's derivative says
// whether to follow. Only a vertex under a face can be trapped: then the highest face above it is next, or it is
// inside. Everything in double, each test in the frame of the shape whose regions it asks. Keeps nothing between calls;
// started from the last answer it mostly ends at once. Weak spot: overlap is found, its depth is not.
#include "narrow/march.h"

#include <algorithm>
#include <limits>

namespace feder {
namespace {

using Kind = Feature::Kind;

using Verdict = MarchVerdict;

// The part of a segment, 0..1, that planes have left, and which of them cut its ends.
struct Clip {
  double lo = 0, hi = 1;
  int low = -1, high = -1;  // labels; -1: the segment's own end
  int out = -1;             // of a plane that has all of it on its far side

  // Keeps what has f >= 0, given f at both ends.
  void cut(double f0, double f1, int label) {
    if (f0 < 0 && f1 < 0) {
      if (out < 0) out = label;
      return;
    }
    if (f0 < 0) {
      const double at = f0 / (f0 - f1);
      if (at > lo) lo = at, low = label;
    } else if (f1 < 0) {
      const double at = f0 / (f0 - f1);
      if (at < hi) hi = at, high = label;
    }
  }
  bool empty() const { return out >= 0 || lo > hi; }
};

Double3 between(const Double3& p, const Double3& q, double t) { return p + t * (q - p); }

// Squared distance of two segments.
double segment_distance(const Double3& p0, const Double3& p1, const Double3& q0, const Double3& q1) {
  const Double3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  const double area = uu * vv - uv * uv;
  double s = area > 1e-14 * uu * vv ? std::min(std::max((uv * vw - vv * uw) / area, 0.0), 1.0) : 0.0;
  double t = (uv * s + vw) / vv;
  if (t < 0 || t > 1) {
    t = t < 0 ? 0.0 : 1.0;
    s = std::min(std::max((uv * t - uw) / uu, 0.0), 1.0);
  }
  const Double3 d = w + s * u - t * v;
  return dot(d, d);
}

class Marcher {
 public:
  Marcher(const ConvexPair& pair, const Features& a, const Features& b) : pair_(pair), side_{&a, &b} {
    slack_ = kMarchSlack * (a.reach + b.reach + length(pair.offset));
    touch_ = kMarchTouch * (a.size + b.size);
  }

  March run(FeaturePair start) {
    March result = march_on(
        at_, start, touch_, [&] { return step(); }, [&](Gap& gap) { fill(gap); });
    const bool bent = side_[0]->bent || side_[1]->bent;
    if (result.end == MarchEnd::apart && bent && !supported(result.gap)) result.end = MarchEnd::bent;
    return result;
  }

 private:
  const Double3& own(int s, std::size_t v) const { return side_[s]->vertices[v]; }
  // A point of side s in the frame of the other one.
  Double3 across(int s, const Double3& p) const {
    return s == 1 ? pair_.from_b(p) : pair_.direction_to_b(p - pair_.offset);
  }
  Double3 seen(int s, std::size_t v) const { return across(s, own(s, v)); }
  Double3 turned(int s, const Double3& d) const {
    return s == 1 ? pair_.from_b(d) - pair_.offset : pair_.direction_to_b(d);
  }
  Double3 away(int s, EdgeUse use) const {
    const Double3& d = side_[s]->edges[use >> 1].direction;
    return use & 1 ? -d : d;
  }
  Verdict move(int s, Kind kind, std::size_t index) {
    at_[s] = {kind, static_cast<std::uint16_t>(index)};
    return Verdict::moved;
  }

  Verdict step() {
    const int s = at_[0].kind <= at_[1].kind ? 0 : 1;  // the side of lower dimension
    const Kind low = at_[s].kind, high = at_[1 - s].kind;
    if (high == Feature::vertex) return two_vertices();
    if (low == Feature::vertex) return high == Feature::edge ? vertex_edge(s) : vertex_face(s);
    if (high == Feature::edge) return two_edges();
    if (low == Feature::edge) return edge_face(s);
    // two faces are never closest alone
    return move(s, Feature::vertex, side_[s]->far_end(side_[s]->loops[side_[s]->faces[at_[s].index].first]));
  }

  Verdict two_vertices() {
    for (int t = 1; t >= 0; --t) {
      const Double3 r = seen(1 - t, at_[1 - t].index) - own(t, at_[t].index);
      double most = slack_;
      int best = -1;
      for (const EdgeUse use : side_[t]->spokes_of(at_[t].index)) {
        const double beyond = dot(r, away(t, use));
        if (beyond > most) most = beyond, best = use >> 1;
      }
      if (best >= 0) return move(t, Feature::edge, static_cast<std::size_t>(best));
    }
    return Verdict::closest;
  }

  // The vertex is on side s.
  Verdict vertex_edge(int s) {
    const int t = 1 - s;
    const Features& f = *side_[t];
    const FeatureEdge& e = f.edges[at_[t].index];
    const Double3 r = seen(s, at_[s].index) - own(t, e.tail);
    if (dot(r, e.direction) < -slack_) return move(t, Feature::vertex, e.tail);
    if (dot(r - (own(t, e.head) - own(t, e.tail)), e.direction) > slack_) return move(t, Feature::vertex, e.head);
    const double left = dot(r, cross(f.faces[e.left].normal, e.direction));
    const double right = dot(r, cross(e.direction, f.faces[e.right].normal));
    if (std::max(left, right) > slack_) return move(t, Feature::face, left >= right ? e.left : e.right);

    // the edge against the region of the vertex
    const Double3 &v = own(s, at_[s].index), q0 = seen(t, e.tail) - v, q1 = seen(t, e.head) - v;
    Clip clip;
    for (const EdgeUse use : side_[s]->spokes_of(at_[s].index)) {
      const Double3 out = away(s, use);
      clip.cut(slack_ - dot(q0, out), slack_ - dot(q1, out), use >> 1);
    }
    return follow(s, clip, Feature::edge, q0, q1, turned(t, e.direction), [](const Double3& x) { return x; });
  }

  // Where the edge q0 q1 of the other side leaves the region of the feature of side s, does it come nearer there?
  // `from`: the vector from that feature to a point.
  template <class From>
  Verdict follow(int s, const Clip& clip, Kind kind, const Double3& q0, const Double3& q1, const Double3& direction,
                 From&& from) {
    if (clip.out >= 0) return move(s, kind, static_cast<std::size_t>(clip.out));
    const auto rate = [&](double t) { return dot(direction, from(between(q0, q1, t))); };
    if (clip.low >= 0 && rate(clip.lo) > slack_) return move(s, kind, static_cast<std::size_t>(clip.low));
    if (clip.high >= 0 && rate(clip.hi) < -slack_) return move(s, kind, static_cast<std::size_t>(clip.high));
    if (clip.lo > clip.hi) return move(s, kind, static_cast<std::size_t>(clip.low));
    return Verdict::closest;
  }

  Verdict vertex_face(int s) {
    const int t = 1 - s;
    const Features& f = *side_[t];
    const FeatureFace& face = f.faces[at_[t].index];
    const Double3 p = seen(s, at_[s].index);
    double least = -slack_;
    int beyond = -1;
    for (const EdgeUse use : f.loop(face)) {
      const double inward = dot(p - own(t, f.edges[use >> 1].tail), cross(face.normal, away(t, use)));
      if (inward < least) least = inward, beyond = use >> 1;
    }
    if (beyond >= 0) return move(t, Feature::edge, static_cast<std::size_t>(beyond));

    // an edge of the vertex that goes towards the plane
    const double height = dot(face.normal, p) - face.offset, sign = height < 0 ? -1 : 1;
    const Double3 n = sign * turned(t, face.normal);
    double steepest = 0;
    int down = -1;
    const Double3& v = own(s, at_[s].index);
    for (const EdgeUse use : side_[s]->spokes_of(at_[s].index)) {
      const double slope = dot(n, away(s, use));
      if (slope < steepest && dot(n, own(s, side_[s]->far_end(use)) - v) < -slack_) steepest = slope, down = use >> 1;
    }
    if (down >= 0) return move(s, Feature::edge, static_cast<std::size_t>(down));
    if (height > touch_) return Verdict::closest;

    // trapped under the face: on to the highest one, if the vertex is outside at all
    double highest = touch_;
    int best = -1;
    for (std::size_t k = 0; k < f.faces.size(); ++k) {
      const double h = dot(f.faces[k].normal, p) - f.faces[k].offset;
      if (h > highest) highest = h, best = static_cast<int>(k);
    }
    if (best < 0) return Verdict::inside;
    return move(t, Feature::face, static_cast<std::size_t>(best));
  }

  // The edge of side s against the region of the edge of the other side, first its ends, then its faces.
  Verdict edge_in_region(int s) {
    const int t = 1 - s;
    const Features& f = *side_[t];
    const FeatureEdge &e = f.edges[at_[t].index], &other = side_[s]->edges[at_[s].index];
    const Double3 tail = own(t, e.tail), q0 = seen(s, other.tail) - tail, q1 = seen(s, other.head) - tail;
    const Double3 direction = turned(s, other.direction);
    const auto from = [&](const Double3& x) { return x - dot(x, e.direction) * e.direction; };
    const double len = dot(own(t, e.head) - tail, e.direction);
    Clip clip;
    const double along0 = dot(q0, e.direction), along1 = dot(q1, e.direction);
    clip.cut(slack_ + along0, slack_ + along1, e.tail);
    clip.cut(slack_ + len - along0, slack_ + len - along1, e.head);
    if (follow(t, clip, Feature::vertex, q0, q1, direction, from) == Verdict::moved) return Verdict::moved;
    clip.low = clip.high = -1;
    const Double3 left = cross(f.faces[e.left].normal, e.direction),
                  right = cross(e.direction, f.faces[e.right].normal);
    clip.cut(slack_ - dot(q0, left), slack_ - dot(q1, left), e.left);
    clip.cut(slack_ - dot(q0, right), slack_ - dot(q1, right), e.right);
    if (clip.lo > clip.hi && clip.low < 0) clip.low = clip.high;
    return follow(t, clip, Feature::face, q0, q1, direction, from);
  }

  Verdict two_edges() {
    if (edge_in_region(1) == Verdict::moved) return Verdict::moved;
    return edge_in_region(0);
  }

  // The edge is on side s.
  Verdict edge_face(int s) {
    const int t = 1 - s;
    const Features& f = *side_[t];
    const FeatureFace& face = f.faces[at_[t].index];
    const FeatureEdge& e = side_[s]->edges[at_[s].index];
    const Double3 q0 = seen(s, e.tail), q1 = seen(s, e.head);
    Clip clip;
    for (const EdgeUse use : f.loop(face)) {
      const Double3 inward = cross(face.normal, away(t, use)), &corner = own(t, f.edges[use >> 1].tail);
      clip.cut(slack_ + dot(q0 - corner, inward), slack_ + dot(q1 - corner, inward), use >> 1);
    }
    if (clip.empty()) {  // it passes by: the nearest side of the face
      double least = std::numeric_limits<double>::infinity();
      std::size_t best = 0;
      for (const EdgeUse use : f.loop(face)) {
        const FeatureEdge& side = f.edges[use >> 1];
        const double d = segment_distance(q0, q1, own(t, side.tail), own(t, side.head));
        if (d < least) least = d, best = use >> 1;
      }
      return move(t, Feature::edge, best);
    }
    const double h0 = dot(face.normal, q0) - face.offset, h1 = dot(face.normal, q1) - face.offset;
    const double low = h0 + clip.lo * (h1 - h0), high = h0 + clip.hi * (h1 - h0);
    if (low * high <= 0) return Verdict::inside;
    const bool to_low = (low > 0 ? h1 - h0 : h0 - h1) >= 0;
    const int by = to_low ? clip.low : clip.high;
    if (by >= 0) return move(t, Feature::edge, static_cast<std::size_t>(by));
    return move(s, Feature::vertex, to_low ? e.tail : e.head);
  }

  // --- the answer, in the frame of a

  Double3 in_a(int s, const Double3& p) const { return s == 1 ? pair_.from_b(p) : p; }
  Double3 turned_to_a(int s, const Double3& d) const { return s == 1 ? turned(1, d) : d; }

  void fill(Gap& gap) const {
    if (at_[0].kind == Feature::edge && at_[1].kind == Feature::edge) return fill_edges(gap);
    const int s = at_[0].kind == Feature::vertex ? 0 : 1, t = 1 - s;
    const Features& f = *side_[t];
    Double3 point[2], normal{0, 0, 0};
    const Double3& v = own(s, at_[s].index);
    point[s] = in_a(s, v);
    const Double3 p = across(s, v);
    Double3 on = own(t, at_[t].kind == Feature::vertex ? at_[t].index : 0u);
    if (at_[t].kind == Feature::edge) {
      const FeatureEdge& e = f.edges[at_[t].index];
      on = own(t, e.tail) + dot(p - own(t, e.tail), e.direction) * e.direction;
    }
    if (at_[t].kind == Feature::face) {
      const FeatureFace& face = f.faces[at_[t].index];
      on = p - (dot(face.normal, p) - face.offset) * face.normal;
      normal = turned_to_a(t, t == 0 ? face.normal : -face.normal);
    }
    point[t] = in_a(t, on);
    finish(point[0], point[1], normal, gap);
  }

  void fill_edges(Gap& gap) const {
    const FeatureEdge &ea = side_[0]->edges[at_[0].index], &eb = side_[1]->edges[at_[1].index];
    const Double3 p = own(0, ea.tail), q = seen(1, eb.tail), u = ea.direction, v = turned(1, eb.direction);
    const double len_a = dot(own(0, ea.head) - p, u), len_b = dot(own(1, eb.head) - own(1, eb.tail), eb.direction);
    const Double3 w = q - p, n = cross(u, v);
    const double sine2 = dot(n, n), cosine = dot(u, v);
    double s, t;
    if (sine2 > 1e-12) {
      s = dot(cross(w, v), n) / sine2;
      t = dot(cross(w, u), n) / sine2;
    } else {  // parallel: the middle of what they have in common
      const double q0 = dot(w, u), q1 = q0 + cosine * len_b;
      const double from = std::max(std::min(q0, q1), 0.0), to = std::min(std::max(q0, q1), len_a);
      s = 0.5 * (from + to);
      t = (s - q0) * cosine;
    }
    s = std::min(std::max(s, 0.0), len_a), t = std::min(std::max(t, 0.0), len_b);
    const double sine = std::sqrt(sine2);
    finish(p + s * u, q + t * v, sine > 1e-4 ? (1 / sine) * n : Double3{0, 0, 0}, gap);
  }

  // `normal`: unit, either way, or zero where only the points tell it.
  void finish(const Double3& a, const Double3& b, const Double3& normal, Gap& gap) const {
    const Double3 d = b - a;
    gap.a = a, gap.b = b;
    if (dot(normal, normal) > 0) {
      const double along = dot(normal, d);
      gap.distance = std::abs(along);
      gap.normal = along < 0 ? -normal : normal;
    } else {
      gap.distance = length(d);
      gap.normal = (gap.distance > 0 ? 1 / gap.distance : 0) * d;
    }
  }

  // Does no corner lie beyond the planes through the closest points?
  bool supported(const Gap& gap) const {
    double first = -std::numeric_limits<double>::infinity(), second = -first;
    for (const Double3& v : side_[0]->vertices) first = std::max(first, dot(gap.normal, v));
    const Double3 n = pair_.direction_to_b(gap.normal);
    for (const Double3& v : side_[1]->vertices) second = std::min(second, dot(n, v));
    second += dot(gap.normal, pair_.offset);
    return second - first >= gap.distance - kBent * (side_[0]->size + side_[1]->size);
  }

  const ConvexPair& pair_;
  const Features* side_[2];
  Feature at_[2]{};
  double slack_ = 0, touch_ = 0;
};

}  // namespace

March march(const ConvexPair& pair, const Features& a, const Features& b, FeaturePair start) {
  return Marcher(pair, a, b).run(start);
}

FeaturePair first_features(const ConvexPair& pair, const Features& a, const Features& b) {
  const Double3 d = pair.from_b(b.vertices[0]) - a.vertices[0], e = -pair.direction_to_b(d);
  const auto farthest = [](const Features& f, const Double3& direction) {
    std::size_t best = 0;
    for (std::size_t v = 1; v < f.vertices.size(); ++v)
      if (dot(direction, f.vertices[v]) > dot(direction, f.vertices[best])) best = v;
    return Feature{Feature::vertex, static_cast<std::uint16_t>(best)};
  };
  return {farthest(a, d), farthest(b, e)};
}

bool within(const Features& f, const Feature& feature) {
  const std::size_t count[3] = {f.vertices.size(), f.edges.size(), f.faces.size()};
  return feature.kind <= Feature::face && feature.index < count[feature.kind];
}

}  // namespace feder
