// Distance of convex cores: Gilbert, Johnson and Keerthi 1988, with the nearest point of the simplex by Voronoi
// regions (Ericson, Real-Time Collision Detection, ch. 5 and 9). In double, in the frame of one shape, so that it
// holds from 1e-4 m to 1e4 m. Ends when a support point gains nothing, comes twice, or the distance stops falling.
// Keeps nothing between calls. Weak spot: curved shapes converge linearly, so the iteration cap can leave an error of
// about 1e-6 of their size.
#include "narrow/gjk.h"

namespace feder {
namespace {

constexpr int kMaxIterations = 80;
constexpr double kTouching = 1e-9;  // of the size of the simplex: nearer cores count as overlapping
constexpr double kGain = 1e-10;     // relative: a support point that gains less ends the search

// The point of a simplex nearest to the origin: on which of its vertices' vertex, edge or face, and its weights there.
struct Nearest {
  int count;
  int vertex[3];
  double weight[3];
};

Nearest nearest_on_edge(const Difference* v, int i, int j) {
  const Double3 &p = v[i].w, &q = v[j].w;
  const Double3 e = q - p;
  const double t = -dot(p, e), len = dot(e, e);
  if (t <= 0 || !(len > 0)) return {1, {i}, {1}};
  if (t >= len) return {1, {j}, {1}};
  const double second = t / len;
  return {2, {i, j}, {1 - second, second}};
}

Nearest nearest_on_triangle(const Difference* v, int i, int j, int k) {
  const Double3 &a = v[i].w, &b = v[j].w, &c = v[k].w;
  const Double3 ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return {1, {i}, {1}};
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return {1, {j}, {1}};
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return {1, {k}, {1}};
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return nearest_on_edge(v, i, j);
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return nearest_on_edge(v, i, k);
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return nearest_on_edge(v, j, k);
  const double sum = va + vb + vc;
  if (!(sum > 0)) return nearest_on_edge(v, i, j);
  const double second = vb / sum, third = vc / sum;
  return {3, {i, j, k}, {1 - second - third, second, third}};
}

Double3 point_of(const Difference* v, const Nearest& n) {
  Double3 p{};
  for (int i = 0; i < n.count; ++i) p = p + n.weight[i] * v[n.vertex[i]].w;
  return p;
}

// False when the origin is inside the tetrahedron.
bool nearest_on_tetrahedron(const Difference* v, Nearest& nearest) {
  constexpr int kFace[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  double best = std::numeric_limits<double>::infinity();
  bool outside = false;
  for (const auto& f : kFace) {
    const Double3 &a = v[f[0]].w, &b = v[f[1]].w, &c = v[f[2]].w, &d = v[f[3]].w;
    const Double3 n = cross(b - a, c - a);
    const double origin = -dot(n, a), opposite = dot(n, d - a);
    if (origin * opposite > 0) {
      // on the inner side of this face, unless that is rounding
      const double flat = 1e-14 * length(n) * (length(d - a) + length(b - a));
      if (std::abs(opposite) > flat) continue;
    }
    outside = true;
    const Nearest here = nearest_on_triangle(v, f[0], f[1], f[2]);
    const Double3 p = point_of(v, here);
    if (dot(p, p) < best) best = dot(p, p), nearest = here;
  }
  return outside;
}

// The vertices of s that its nearest point needs. False when s holds the origin.
bool reduce_to_nearest(const Simplex& s, Simplex& reduced) {
  Nearest n{1, {0}, {1}};
  if (s.count == 2) n = nearest_on_edge(s.v, 0, 1);
  if (s.count == 3) n = nearest_on_triangle(s.v, 0, 1, 2);
  if (s.count == 4 && !nearest_on_tetrahedron(s.v, n)) return false;
  reduced.count = n.count;
  for (int i = 0; i < n.count; ++i) reduced.v[i] = s.v[n.vertex[i]], reduced.weight[i] = n.weight[i];
  return true;
}

Double3 nearest_point(const Simplex& s) {
  Double3 p{};
  for (int i = 0; i < s.count; ++i) p = p + s.weight[i] * s.v[i].w;
  return p;
}

bool has_vertex(const Simplex& s, const Double3& w) {
  for (int i = 0; i < s.count; ++i)
    if (s.v[i].w.x == w.x && s.v[i].w.y == w.y && s.v[i].w.z == w.z) return true;
  return false;
}

void fill_gap(const Simplex& s, const Double3& v, Gap& gap) {
  gap.a = gap.b = {};
  for (int i = 0; i < s.count; ++i) {
    gap.a = gap.a + s.weight[i] * s.v[i].a;
    gap.b = gap.b + s.weight[i] * s.v[i].b;
  }
  gap.distance = length(v);
  gap.normal = (-1 / gap.distance) * v;
}

}  // namespace

Vec3 Convex::support(const Vec3& d) const {
  if (shape) return scale == 1 ? shape->support(d) : Vec3(center + scale * (shape->support(d) - center));
  int best = 0;
  for (int i = 1; i < count; ++i)
    if (dot(points[i], d) > dot(points[best], d)) best = i;
  return points[best];
}

int Convex::face(const Vec3& d, Vec3* out) const {
  if (shape) return shape->face(d, out);
  for (int i = 0; i < count; ++i) out[i] = points[i];
  return count;
}

ConvexPair::ConvexPair(const Convex& first, const Pose& pose_a, const Convex& second, const Pose& pose_b)
    : a(first), b(second) {
  const Quat q = conjugate(pose_a.rotation) * pose_b.rotation;
  const double x = q.x, y = q.y, z = q.z, w = q.w, s = 2 / (x * x + y * y + z * z + w * w);
  row[0] = {1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)};
  row[1] = {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)};
  row[2] = {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)};
  offset = wide(rotate_inverse(pose_a.rotation, pose_b.position - pose_a.position));
}

Difference support(const ConvexPair& pair, const Double3& direction) {
  Difference d;
  d.a = wide(pair.a.support(narrow(direction)));
  d.b = pair.from_b(wide(pair.b.support(narrow(pair.direction_to_b(-direction)))));
  d.w = d.a - d.b;
  return d;
}

bool gjk_distance(const ConvexPair& pair, const Double3& start, double enough, Simplex& simplex, Gap& gap) {
  Double3 v = start;
  double len = length(v);
  if (!(len > 0)) v = {0, 1, 0}, len = 1;
  const Double3 first = (-1 / len) * v;
  simplex.v[0] = support(pair, first);
  simplex.count = 1;
  simplex.weight[0] = 1;
  v = simplex.v[0].w;
  // a start that separates them far enough, as the axis of the last step mostly does, is the answer
  const double apart = -dot(first, v);
  if (apart > enough) {
    gap = {apart, simplex.v[0].a, simplex.v[0].b, first};
    return true;
  }
  // two simplices take turns: the nearest one so far, and the next
  Simplex other;
  Simplex *nearest = &other, *next = &simplex;
  double size = length(v), best = std::numeric_limits<double>::infinity();
  Double3 nearest_v = v;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    len = length(v);
    if (!(len > kTouching * size)) {
      if (next != &simplex) simplex = *next;
      return false;
    }
    if (len >= best) break;  // rounding has the last word
    best = len, nearest_v = v;
    std::swap(nearest, next);
    const Difference found = support(pair, (-1 / len) * v);
    size = std::max(size, length(found.w));
    const double bound = dot(v, found.w) / len;  // no point of the difference is nearer along v
    if (bound > enough) {
      fill_gap(*nearest, v, gap);
      gap.distance = bound;
      return true;
    }
    if (len - bound <= kGain * len || has_vertex(*nearest, found.w)) break;
    nearest->v[nearest->count++] = found;
    if (!reduce_to_nearest(*nearest, *next)) {
      if (nearest != &simplex) simplex = *nearest;
      return false;
    }
    --nearest->count;
    v = nearest_point(*next);
  }
  fill_gap(*nearest, nearest_v, gap);
  return true;
}

bool core_gap(const ConvexPair& pair, const Double3& start, double enough, Gap& gap) {
  Simplex simplex;
  if (gjk_distance(pair, start, enough, simplex, gap)) return gap.distance <= enough;
  gap = epa_depth(pair, simplex);
  return true;
}

}  // namespace feder
