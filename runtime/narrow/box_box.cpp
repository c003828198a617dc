// Box against box: separating axes (Gottschalk, Lin and Manocha 1996), then one-shot clipping of the incident face
// against the sides of the reference face (Sutherland and Hodgman 1974), or the nearest points of two edges.
// Everything is in scalars in the frame of one box, so that stacks give normals exactly along their faces. Face axes
// win over edge axes, and faces of a over faces of b, unless the other is better by a small part of the boxes' size:
// otherwise resting boxes would flicker between axes of equal depth, and lose their warm start. Of a long thin box a
// face axis measures the far ends too: where an edge axis wins that is nearly a face normal, and that face overlaps no
// deeper here, the face gives the points (a rod across another one would roll on a single point). Kept between calls:
// the last separating axis, tried first. Weak spot: when the boxes are apart corner to corner, the separation along the
// best axis is shorter than the distance (both are beyond zero).
#include "geom/box.h"

#include "narrow/clip.h"
#include "narrow/narrow_phase.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr Real kPreference = Real(0.005);      // of the smallest half size: how much better a later axis must be
constexpr Real kParallelSquared = Real(1e-6);  // edges within 1 mrad give no axis of their own
constexpr Real kAligned = Real(0.99);          // cosine; an edge axis nearer to a face normal takes that face's points
constexpr Real kDeeper = Real(0.01);           // of the smallest half size, that those may overlap deeper
constexpr Real kClipSlack = Real(1e-4);        // of the reference face: flush sides keep their corners
constexpr int kNext[3] = {1, 2, 0}, kLast[3] = {2, 0, 1};

// Box b seen from box a: r[i][j] = axis i of a . axis j of b.
struct Relative {
  Real r[3][3], abs_r[3][3];
  Real t[3];        // centre of b from a, along the axes of a
  Real h[3], g[3];  // half sizes of a and b

  Real face_a(int i) const {
    return std::abs(t[i]) - (h[i] + g[0] * abs_r[i][0] + g[1] * abs_r[i][1] + g[2] * abs_r[i][2]);
  }
  Real along_b(int j) const { return t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j]; }
  Real face_b(int j) const {
    return std::abs(along_b(j)) - (g[j] + h[0] * abs_r[0][j] + h[1] * abs_r[1][j] + h[2] * abs_r[2][j]);
  }
  // Along a_i x b_j, which is as long as sqrt(edge_squared): not normalised.
  Real edge_offset(int i, int j) const { return t[kLast[i]] * r[kNext[i]][j] - t[kNext[i]] * r[kLast[i]][j]; }
  Real edge_squared(int i, int j) const { return r[kNext[i]][j] * r[kNext[i]][j] + r[kLast[i]][j] * r[kLast[i]][j]; }
  Real edge(int i, int j) const {
    return std::abs(edge_offset(i, j)) - (h[kNext[i]] * abs_r[kLast[i]][j] + h[kLast[i]] * abs_r[kNext[i]][j] +
                                          g[kNext[j]] * abs_r[i][kLast[j]] + g[kLast[j]] * abs_r[i][kNext[j]]);
  }
  bool edge_apart(int i, int j, Real margin) const {
    const Real d = edge(i, j), squared = edge_squared(i, j);
    return d > 0 && squared > kParallelSquared && d * d > margin * margin * squared;
  }
  bool apart(std::uint32_t axis, Real margin) const {  // axes: 0..2 of a, 3..5 of b, then 9 pairs of edges
    if (axis < 3) return face_a(static_cast<int>(axis)) > margin;
    if (axis < 6) return face_b(static_cast<int>(axis) - 3) > margin;
    return edge_apart(static_cast<int>(axis - 6) / 3, static_cast<int>(axis - 6) % 3, margin);
  }
};

Relative relative_boxes(const Mat3& ra, const Mat3& rb, const Vec3& d, const Vec3& half_a, const Vec3& half_b) {
  Relative rel;
  for (int i = 0; i < 3; ++i) {
    rel.t[i] = ra(0, i) * d[0] + ra(1, i) * d[1] + ra(2, i) * d[2];
    rel.h[i] = half_a[i];
    rel.g[i] = half_b[i];
    for (int j = 0; j < 3; ++j) {
      rel.r[i][j] = ra(0, i) * rb(0, j) + ra(1, i) * rb(1, j) + ra(2, i) * rb(2, j);
      rel.abs_r[i][j] = std::abs(rel.r[i][j]);
    }
  }
  return rel;
}

// The incident face in the frame of the reference box. Edges: 0..3 of the incident face, 4..7 sides of the reference
// face.
using Loop = ClipLoop<8>;

// `rel`: the reference box is a; its face `axis`, on the side of the other box, takes the points.
int face_points(const Relative& rel, int axis, const Pose& reference, const Mat3& rotation, std::uint32_t code,
                Real margin, ManifoldPoint* out) {
  const Real side = rel.t[axis] < 0 ? Real(-1) : Real(1);
  int j = 0;
  for (int k = 1; k < 3; ++k)
    if (rel.abs_r[axis][k] > rel.abs_r[axis][j]) j = k;
  const Real facing = rel.r[axis][j] * side > 0 ? Real(-1) : Real(1);
  const int u = kNext[j], v = kLast[j];
  Loop loop;
  loop.count = 4;
  constexpr Real kU[4] = {1, -1, -1, 1}, kV[4] = {1, 1, -1, -1};
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k)
      loop.p[i][k] =
          rel.t[k] + facing * rel.g[j] * rel.r[k][j] + kU[i] * rel.g[u] * rel.r[k][u] + kV[i] * rel.g[v] * rel.r[k][v];
    loop.edge[i] = static_cast<std::uint8_t>(i);
  }
  const int x = kNext[axis], y = kLast[axis];
  const Real slack = kClipSlack * std::min(rel.h[x], rel.h[y]);
  const auto cut = [&](int side_axis, Real sign, std::uint8_t label) {
    const Real limit = rel.h[side_axis] + slack;
    clip(loop, true, label, [=](const Vec3& p) { return sign * p[side_axis] - limit; });
  };
  cut(x, 1, 4), cut(y, 1, 5), cut(x, -1, 6), cut(y, -1, 7);

  code = code << 4 | (side < 0 ? 8u : 0u) | static_cast<std::uint32_t>(j) << 1 | (facing < 0 ? 1u : 0u);
  int count = 0;
  for (int i = 0; i < loop.count; ++i) {
    Vec3& p = loop.p[i];
    const Real separation = side * p[axis] - rel.h[axis];
    if (separation > margin) continue;
    p[axis] = side * (rel.h[axis] + separation / 2);
    ManifoldPoint& point = out[count++];
    for (int k = 0; k < 3; ++k)
      point.position[k] =
          reference.position[k] + (rotation(k, 0) * p[0] + rotation(k, 1) * p[1] + rotation(k, 2) * p[2]);
    point.separation = separation;
    point.feature =
        code << 8 | static_cast<std::uint32_t>(loop.edge[i > 0 ? i - 1 : loop.count - 1]) << 4 | loop.edge[i];
  }
  return count;
}

// The nearest points of the two edges that look at each other across a_i x b_j.
void edge_point(const Relative& rel, int i, int j, const Pose& pose_a, const Mat3& ra, Manifold& out) {
  const Real sign = (rel.edge_offset(i, j) < 0 ? Real(-1) : Real(1)) / std::sqrt(rel.edge_squared(i, j));
  Real n[3], p[3], q[3], b[3];
  n[i] = 0;
  n[kNext[i]] = -sign * rel.r[kLast[i]][j];
  n[kLast[i]] = sign * rel.r[kNext[i]][j];
  std::uint32_t code = 1u << 31 | static_cast<std::uint32_t>(i * 3 + j) << 8;
  for (int k = 0; k < 3; ++k) {
    p[k] = k == i ? Real(0) : (n[k] < 0 ? -rel.h[k] : rel.h[k]);
    q[k] = rel.t[k];
    b[k] = rel.r[k][j];
    code |= (p[k] < 0 ? 1u : 0u) << k;
  }
  for (int k = 0; k < 3; ++k) {
    if (k == j) continue;
    const Real s = n[0] * rel.r[0][k] + n[1] * rel.r[1][k] + n[2] * rel.r[2][k];
    for (int c = 0; c < 3; ++c) q[c] += (s < 0 ? rel.g[k] : -rel.g[k]) * rel.r[c][k];
    code |= (s < 0 ? 1u : 0u) << (3 + k);
  }
  // lines p + x e_i and q + y b: the gap is across both
  Real d[3], db = 0;
  for (int k = 0; k < 3; ++k) d[k] = q[k] - p[k], db += d[k] * b[k];
  const Real e = b[i];
  const Real y = clamp((e * d[i] - db) / (Real(1) - e * e), -rel.g[j], rel.g[j]);
  const Real x = clamp(d[i] + y * e, -rel.h[i], rel.h[i]);
  p[i] += x;
  Real separation = 0, mid[3];
  for (int k = 0; k < 3; ++k) {
    const Real w = q[k] + y * b[k];
    separation += (w - p[k]) * n[k];
    mid[k] = (p[k] + w) / 2;
  }
  out.count = 1;
  out.points[0].separation = separation;
  out.points[0].feature = code;
  for (int k = 0; k < 3; ++k) {
    out.normal[k] = ra(k, 0) * n[0] + ra(k, 1) * n[1] + ra(k, 2) * n[2];
    out.points[0].position[k] = pose_a.position[k] + (ra(k, 0) * mid[0] + ra(k, 1) * mid[1] + ra(k, 2) * mid[2]);
  }
}

// The same two boxes seen from b.
Relative swapped(const Relative& rel) {
  Relative back;
  for (int i = 0; i < 3; ++i) {
    back.t[i] = -rel.along_b(i);
    back.h[i] = rel.g[i];
    back.g[i] = rel.h[i];
    for (int j = 0; j < 3; ++j) back.r[i][j] = rel.r[j][i], back.abs_r[i][j] = rel.abs_r[j][i];
  }
  return back;
}

struct Axis {
  std::uint32_t index = 0;
  Real separation = -kInfinity;
};

// The axis of largest separation with the preferences above; false when it is beyond the margin.
bool best_axis(const Relative& rel, Real margin, Real preference, PairCache& cache, Axis& best, Axis& edge) {
  const auto found_apart = [&](int axis) { return cache.word[0] = static_cast<std::uint32_t>(axis) + 1, false; };
  Axis b;
  for (int i = 0; i < 3; ++i) {
    const Real s = rel.face_a(i);
    if (s > margin) return found_apart(i);
    if (s > best.separation) best = {static_cast<std::uint32_t>(i), s};
  }
  for (int j = 0; j < 3; ++j) {
    const Real s = rel.face_b(j);
    if (s > margin) return found_apart(3 + j);
    if (s > b.separation) b = {static_cast<std::uint32_t>(3 + j), s};
  }
  if (b.separation > best.separation + preference) best = b;
  const Real beat = best.separation + preference;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Real s = rel.edge(i, j);
      if (s <= beat && s <= 0) continue;  // dividing by a length below 1 only makes it worse
      const Real squared = rel.edge_squared(i, j);
      if (squared < kParallelSquared) continue;
      s /= std::sqrt(squared);
      if (s > margin) return found_apart(6 + 3 * i + j);
      if (s > beat && s > edge.separation) edge = {static_cast<std::uint32_t>(6 + 3 * i + j), s};
    }
  }
  cache.word[0] = 0;
  return true;
}

// The face axis nearest to an axis a_i x b_j; separation: its cosine.
Axis nearest_face(const Relative& rel, std::uint32_t edge) {
  const int i = static_cast<int>(edge - 6) / 3, j = static_cast<int>(edge - 6) % 3;
  const Real scale = 1 / std::sqrt(rel.edge_squared(i, j));
  Axis best;
  const auto take = [&](int axis, Real dot) {
    if (std::abs(dot) * scale > best.separation) best = {static_cast<std::uint32_t>(axis), std::abs(dot) * scale};
  };
  // a_i x b_j is (-r[last][j], r[next][j]) along a_next, a_last, and likewise along the axes of b
  take(kNext[i], rel.r[kLast[i]][j]), take(kLast[i], rel.r[kNext[i]][j]);
  take(3 + kNext[j], rel.r[i][kLast[j]]), take(3 + kLast[j], rel.r[i][kNext[j]]);
  return best;
}

int box_box(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache& cache,
            Manifold* out) {
  const Mat3 ra = to_matrix(pose_a.rotation), rb = to_matrix(pose_b.rotation);
  const Vec3 d = pose_b.position - pose_a.position;
  const Relative rel = relative_boxes(ra, rb, d, static_cast<const Box&>(a).half(), static_cast<const Box&>(b).half());
  if (cache.word[0] - 1 < 15u && rel.apart(cache.word[0] - 1, margin)) return 0;

  const Real smallest = std::min(std::min({rel.h[0], rel.h[1], rel.h[2]}), std::min({rel.g[0], rel.g[1], rel.g[2]}));
  Axis best, edge;
  if (!best_axis(rel, margin, kPreference * smallest, cache, best, edge)) return 0;
  ManifoldPoint points[8];
  const auto points_of = [&](std::uint32_t axis) {
    const int i = static_cast<int>(axis) % 3;
    if (axis < 3) {
      out->normal = rel.t[i] < 0 ? Vec3(-ra.col(i)) : Vec3(ra.col(i));
      return face_points(rel, i, pose_a, ra, axis, margin, points);
    }
    const Relative back = swapped(rel);
    out->normal = back.t[i] < 0 ? Vec3(rb.col(i)) : Vec3(-rb.col(i));
    return face_points(back, i, pose_b, rb, axis, margin, points);
  };
  if (!(edge.separation > best.separation)) {
    const int count = points_of(best.index);
    reduce_points({points, static_cast<std::size_t>(count)}, out->normal, *out);
    return count > 0 ? 1 : 0;
  }
  edge_point(rel, static_cast<int>(edge.index - 6) / 3, static_cast<int>(edge.index - 6) % 3, pose_a, ra, *out);
  const Axis face = nearest_face(rel, edge.index);
  if (face.separation < kAligned) return 1;
  // the face's points, measured along the edge axis
  const Manifold single = *out;
  const int count = points_of(face.index);
  Real deepest = kInfinity;
  for (int k = 0; k < count; ++k) deepest = std::min(deepest, points[k].separation *= face.separation);
  out->normal = single.normal;
  if (count > 1 && deepest > edge.separation - kDeeper * smallest)
    reduce_points({points, static_cast<std::size_t>(count)}, out->normal, *out);
  else
    *out = single;
  return 1;
}

}  // namespace

PairRow narrow_box_box() { return {"box", "box", box_box}; }

}  // namespace feder
