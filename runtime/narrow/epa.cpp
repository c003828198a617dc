// Depth of overlapping cores: the expanding polytope of van den Bergen (2001). Starts from the simplex that GJK ended
// with, made into a tetrahedron; a difference without volume (two crossing segments, a point inside a triangle) has
// depth 0 across its plane. In double. Weak spot: on curved shapes the polytope approaches from inside, so the depth is
// low by up to kExact of the size, and the normal is off by the root of that.
#include "narrow/gjk.h"

namespace feder {
namespace {

constexpr int kMaxVertices = 128;
constexpr int kMaxFaces = 256;
constexpr double kExact = 1e-7;  // of the size of the polytope
constexpr double kFlat = 1e-10;  // of the size: thinner polytopes have no volume

struct Face {
  int v[3];
  int next[3];  // neighbour across the edge from v[i] to v[i + 1]
  bool alive;
  Double3 normal;  // unit, outward
  double distance;

  int edge_from(int vertex) const { return v[0] == vertex ? 0 : (v[1] == vertex ? 1 : 2); }
};

struct Polytope {
  Difference v[kMaxVertices];
  Face faces[kMaxFaces];
  int vertices = 0, face_count = 0;
  double size = 0;

  void add_vertex(const Difference& d) {
    v[vertices++] = d;
    size = std::max(size, length(d.w - v[0].w));
  }
  // -1 when the triangle has no area.
  int add_face(int i, int j, int k) {
    const Double3 n = cross(v[j].w - v[i].w, v[k].w - v[i].w);
    const double len = length(n);
    if (!(len > 1e-20 * size * size)) return -1;
    int slot = 0;
    while (slot < face_count && faces[slot].alive) ++slot;
    if (slot == kMaxFaces) return -1;
    if (slot == face_count) ++face_count;
    const Double3 unit = (1 / len) * n;
    faces[slot] = {{i, j, k}, {-1, -1, -1}, true, unit, dot(unit, v[i].w)};
    return slot;
  }
  void join(int f, int edge_f, int g, int edge_g) { faces[f].next[edge_f] = g, faces[g].next[edge_g] = f; }
  int nearest_face() const {
    int best = -1;
    for (int i = 0; i < face_count; ++i)
      if (faces[i].alive && (best < 0 || faces[i].distance < faces[best].distance)) best = i;
    return best;
  }
};

// The support point, of both directions along `axis`, that is farther from the plane or line through v[0].
bool widen(const ConvexPair& pair, Polytope& p, const Double3& axis) {
  const Difference up = support(pair, axis), down = support(pair, -axis);
  const double high = dot(axis, up.w - p.v[0].w), low = dot(axis, p.v[0].w - down.w);
  p.size = std::max({p.size, length(up.w - p.v[0].w), length(down.w - p.v[0].w)});
  if (!(std::max(high, low) > kFlat * p.size)) return false;
  p.add_vertex(high >= low ? up : down);
  return true;
}

Double3 unit(const Double3& d) { return (1 / length(d)) * d; }

Double3 across(const Double3& d) {
  const double x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
  return unit(cross(d, x <= y && x <= z ? Double3{1, 0, 0} : (y <= z ? Double3{0, 1, 0} : Double3{0, 0, 1})));
}

// Makes four vertices with a volume. Else returns false, with `flat` across what there is.
bool make_tetrahedron(const ConvexPair& pair, const Simplex& s, Polytope& p, Double3& flat) {
  p.add_vertex(s.v[0]);
  for (int i = 1; i < s.count; ++i) p.size = std::max(p.size, length(s.v[i].w - s.v[0].w));
  // simplex vertices are only taken while they add a dimension
  int next = 1;
  for (; next < s.count && p.vertices < 2; ++next)
    if (length(s.v[next].w - p.v[0].w) > kFlat * p.size) p.add_vertex(s.v[next]);
  flat = {0, 1, 0};
  constexpr Double3 kAxes[3] = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < 3 && p.vertices < 2; ++i) widen(pair, p, kAxes[i]);
  if (p.vertices < 2) return false;

  const Double3 line = unit(p.v[1].w - p.v[0].w);
  for (; next < s.count && p.vertices < 3; ++next)
    if (length(cross(s.v[next].w - p.v[0].w, line)) > kFlat * p.size) p.add_vertex(s.v[next]);
  flat = across(line);
  if (p.vertices < 3) widen(pair, p, flat);
  if (p.vertices < 3) {
    const Double3 other = cross(line, flat);
    if (!widen(pair, p, other)) return false;
  }
  const Double3 n = unit(cross(p.v[1].w - p.v[0].w, p.v[2].w - p.v[0].w));
  flat = n;
  for (; next < s.count && p.vertices < 4; ++next)
    if (std::abs(dot(n, s.v[next].w - p.v[0].w)) > kFlat * p.size) p.add_vertex(s.v[next]);
  return p.vertices == 4 || widen(pair, p, n);
}

struct RimEdge {
  int from, to, outer;  // outer: the face that stays
};

// Removes the connected faces that see vertex `w`, starting at `seed`; their rim comes out in order.
int remove_visible(Polytope& p, int seed, int w, RimEdge* rim) {
  struct Visit {
    int face, edge;  // the edge to look across
  };
  Visit stack[2 * kMaxFaces];
  int depth = 0, count = 0;
  p.faces[seed].alive = false;
  for (int e = 2; e >= 0; --e) stack[depth++] = {seed, e};
  while (depth > 0) {
    const Visit at = stack[--depth];
    const Face& from = p.faces[at.face];
    const int a = from.v[at.edge], b = from.v[(at.edge + 1) % 3], neighbor = from.next[at.edge];
    Face& face = p.faces[neighbor];
    if (!face.alive) continue;
    if (dot(face.normal, p.v[w].w) - face.distance <= 0) {
      if (count == kMaxFaces) return 0;
      rim[count++] = {a, b, neighbor};
      continue;
    }
    face.alive = false;
    const int entered = face.edge_from(b);
    if (depth + 2 > 2 * kMaxFaces) return 0;
    stack[depth++] = {neighbor, (entered + 2) % 3};
    stack[depth++] = {neighbor, (entered + 1) % 3};
  }
  return count;
}

// Replaces the faces that see vertex `w` by a cone over their rim. False when rounding has spoilt the polytope.
bool expand(Polytope& p, int seed, int w) {
  RimEdge rim[kMaxFaces];
  int made[kMaxFaces];
  const int count = remove_visible(p, seed, w, rim);
  if (count < 3) return false;
  for (int i = 0; i < count; ++i)
    if (rim[i].to != rim[(i + 1) % count].from) return false;
  for (int i = 0; i < count; ++i) {
    made[i] = p.add_face(rim[i].from, rim[i].to, w);
    if (made[i] < 0) return false;
    p.join(made[i], 0, rim[i].outer, p.faces[rim[i].outer].edge_from(rim[i].to));
  }
  for (int i = 0; i < count; ++i) p.join(made[i], 1, made[(i + 1) % count], 2);
  return true;
}

bool known(const Polytope& p, const Double3& w) {
  for (int i = 0; i < p.vertices; ++i)
    if (p.v[i].w.x == w.x && p.v[i].w.y == w.y && p.v[i].w.z == w.z) return true;
  return false;
}

// Deepest points: the origin's projection on the face, in its corners' weights.
Gap gap_of(const Polytope& p, const Face& f) {
  const Difference &a = p.v[f.v[0]], &b = p.v[f.v[1]], &c = p.v[f.v[2]];
  const Double3 o = f.distance * f.normal;
  const double whole = dot(f.normal, cross(b.w - a.w, c.w - a.w));
  double wb = dot(f.normal, cross(o - a.w, c.w - a.w)) / whole;
  double wc = dot(f.normal, cross(b.w - a.w, o - a.w)) / whole;
  wb = std::min(std::max(wb, 0.0), 1.0);
  wc = std::min(std::max(wc, 0.0), 1.0 - wb);
  const double wa = 1 - wb - wc;
  return {-f.distance, wa * a.a + wb * b.a + wc * c.a, wa * a.b + wb * b.b + wc * c.b, f.normal};
}

Gap flat_gap(const ConvexPair& pair, const Simplex& s, const Double3& normal) {
  Gap gap;
  gap.normal = dot(normal, pair.offset) < 0 ? -normal : normal;
  for (int i = 0; i < s.count; ++i) {
    const double weight = s.count < 4 ? s.weight[i] : 0.25;
    gap.a = gap.a + weight * s.v[i].a;
    gap.b = gap.b + weight * s.v[i].b;
  }
  return gap;
}

}  // namespace

Gap epa_depth(const ConvexPair& pair, const Simplex& simplex) {
  Polytope p;
  Double3 flat;
  if (!make_tetrahedron(pair, simplex, p, flat)) return flat_gap(pair, simplex, flat);
  if (dot(cross(p.v[1].w - p.v[0].w, p.v[2].w - p.v[0].w), p.v[3].w - p.v[0].w) > 0) std::swap(p.v[1], p.v[2]);
  constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  constexpr int kNext[4][3] = {{1, 3, 2}, {2, 3, 0}, {0, 3, 1}, {1, 2, 0}};
  for (int f = 0; f < 4; ++f) {
    if (p.add_face(kFaces[f][0], kFaces[f][1], kFaces[f][2]) != f) return flat_gap(pair, simplex, flat);
    for (int e = 0; e < 3; ++e) p.faces[f].next[e] = kNext[f][e];
  }
  // every support plane bounds the depth from above: the least one seen is the answer
  Gap best;
  double least = std::numeric_limits<double>::infinity();
  for (;;) {
    const int nearest = p.nearest_face();
    const Face& face = p.faces[nearest];
    const Difference next = support(pair, face.normal);
    const double bound = dot(face.normal, next.w);
    if (bound < least) {
      least = bound;
      best = gap_of(p, face);
      best.distance = -bound;
    }
    if (least - face.distance <= kExact * p.size || known(p, next.w) || p.vertices == kMaxVertices) return best;
    p.add_vertex(next);
    if (!expand(p, nearest, p.vertices - 1)) return best;
  }
}

}  // namespace feder
