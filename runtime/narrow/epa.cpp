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
  Double3 normal;  // unit, outward
  double distance;
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
  // False when the triangle has no area.
  bool add_face(int i, int j, int k) {
    const Double3 n = cross(v[j].w - v[i].w, v[k].w - v[i].w);
    const double len = length(n);
    if (!(len > 1e-20 * size * size) || face_count == kMaxFaces) return false;
    const Double3 unit = (1 / len) * n;
    faces[face_count++] = {{i, j, k}, unit, dot(unit, v[i].w)};
    return true;
  }
  int nearest_face() const {
    int best = 0;
    for (int i = 1; i < face_count; ++i)
      if (faces[i].distance < faces[best].distance) best = i;
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

// Replaces the faces that see vertex `w` by a cone over their rim. False when rounding has spoilt the polytope.
bool expand(Polytope& p, int w) {
  struct Edge {
    int from, to;
  };
  Edge rim[kMaxFaces];
  int rim_count = 0, kept = 0;
  for (int f = 0; f < p.face_count; ++f) {
    const Face face = p.faces[f];
    if (dot(face.normal, p.v[w].w) - face.distance <= 1e-14 * p.size) {
      p.faces[kept++] = face;
      continue;
    }
    for (int e = 0; e < 3; ++e) {
      const int from = face.v[e], to = face.v[(e + 1) % 3];
      int twin = 0;
      while (twin < rim_count && !(rim[twin].from == to && rim[twin].to == from)) ++twin;
      if (twin < rim_count) {
        rim[twin] = rim[--rim_count];
      } else if (rim_count < kMaxFaces) {
        rim[rim_count++] = {from, to};
      } else {
        return false;
      }
    }
  }
  p.face_count = kept;
  if (rim_count < 3) return false;
  for (int e = 0; e < rim_count; ++e)
    if (!p.add_face(rim[e].from, rim[e].to, w)) return false;
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
  const bool turned = dot(cross(p.v[1].w - p.v[0].w, p.v[2].w - p.v[0].w), p.v[3].w - p.v[0].w) > 0;
  constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  for (const auto& f : kFaces)
    if (!(turned ? p.add_face(f[0], f[2], f[1]) : p.add_face(f[0], f[1], f[2]))) return flat_gap(pair, simplex, flat);
  Gap best = gap_of(p, p.faces[p.nearest_face()]);
  while (p.vertices < kMaxVertices) {
    const Face face = p.faces[p.nearest_face()];
    best = gap_of(p, face);
    const Difference next = support(pair, face.normal);
    if (dot(face.normal, next.w) - face.distance <= kExact * p.size || known(p, next.w)) break;
    p.add_vertex(next);
    if (!expand(p, p.vertices - 1)) break;
  }
  return best;
}

}  // namespace feder
