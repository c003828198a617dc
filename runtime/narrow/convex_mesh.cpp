// Any convex shape against a triangle mesh. Each triangle near the shape is tested alone; the seams between triangles
// must not be felt. So a triangle pushes along its own normal, on the side where the shape's middle is, and only where
// the shape is over it; an edge or a corner may push along another direction only when it is sharp (its neighbours fall
// away), and only as far round as the neighbour's normal. Mostly that needs no search: the deepest point p of the core
// along the normal, delta below the triangle and at least delta inside each of its sharp edges, is the answer, since
// along a direction at an angle x to the normal the overlap is at least delta cos x + delta sin x >= delta. Else GJK
// and EPA decide. Points with nearly one normal, on triangles with one surface, form one manifold; of these the
// deepest kMeshManifolds are returned. Where there are more, those that differ by their surface alone become one first,
// so that nothing rests on less than it would on a mesh without surfaces.
// Triangles come in ascending order: deterministic.
// Keeps nothing between calls. Weak spot: a shape whose middle has passed the surface is pushed out on the far side.
#include "narrow/narrow_phase.h"
#include "narrow/patch.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr Real kFaceCosine = Real(0.9995);    // a push this near to the face normal is the face's
constexpr Real kClusterCosine = Real(0.996);  // normals within 5 degrees share a manifold
constexpr Real kVoronoiSlack = Real(0.01);    // in the cosine: how far past the neighbour's normal an edge may push
constexpr double kOnEdge = 1e-4;              // barycentric: nearer than this to an edge is on it
constexpr Real kShallower = Real(0.1);        // of the margin: face points less deep than the edge by more give way
constexpr int kClusters = 8;
constexpr int kClusterPoints = 24;

struct Cluster {
  Cluster() {}
  Vec3 normal;  // from the shape to the mesh, in the mesh's frame
  Real deepest = kInfinity;
  int count = 0;
  SurfaceNumber surface = 0;
  union {  // not filled before use
    ManifoldPoint points[kClusterPoints];
  };
};

struct MeshContact {
  MeshContact(const Shape& shape, const Shape& to, const Pose& at, Real limit)
      : mesh(to), local(at), margin(limit), pair(Convex(shape), at, Convex(nullptr, 3), Pose{}),
        enough(double(limit) + shape.radius()) {
    const Aabb box = shape.bounds(Pose{});
    lo = wide(box.lo), hi = wide(box.hi);
    for (double* x : {&lo.x, &lo.y, &lo.z}) *x -= double(limit);
    for (double* x : {&hi.x, &hi.y, &hi.z}) *x += double(limit);
  }
  const Shape& mesh;
  const Pose& local;  // the shape in the frame of the mesh
  const Real margin;
  Vec3 middle = Vec3::Zero(), half = Vec3::Zero();  // of its box with the margin there, m
  ConvexPair pair;                                  // with a triangle as b
  Double3 lo, hi;                                   // of the shape and the margin, in its own frame
  double enough;                                    // between the cores
  int count = 0;
  Cluster clusters[kClusters];
};

void reduce_cluster(Cluster& c) {
  Manifold m;
  reduce_points({c.points, static_cast<std::size_t>(c.count)}, c.normal, m);
  c.count = m.count;
  for (int i = 0; i < m.count; ++i) c.points[i] = m.points[i];
}

bool one_normal(const Cluster& c, const Vec3& normal) { return dot(c.normal, normal) > kClusterCosine; }

void add_point(Cluster& c, const ManifoldPoint& p) {
  if (c.count == kClusterPoints) reduce_cluster(c);
  c.points[c.count++] = p;
  c.deepest = std::min(c.deepest, p.separation);
}

// The cluster for `normal` and `surface`, or a new one; when full, one of another surface, or the shallowest is given
// up if this is deeper.
Cluster* cluster_for(MeshContact& mc, const Vec3& normal, SurfaceNumber surface, Real deepest) {
  Cluster* other = nullptr;
  for (int i = 0; i < mc.count; ++i) {
    Cluster& c = mc.clusters[i];
    if (!one_normal(c, normal)) continue;
    if (c.surface == surface) return &c;
    if (!other) other = &c;
  }
  if (other && mc.count == kClusters) return other;
  Cluster* free = nullptr;
  if (mc.count < kClusters) {
    free = &mc.clusters[mc.count++];
  } else {
    free = &mc.clusters[0];
    for (Cluster& c : mc.clusters)
      if (c.deepest > free->deepest) free = &c;
    if (free->deepest <= deepest) return nullptr;
  }
  free->normal = normal;
  free->surface = surface;
  free->deepest = kInfinity;
  free->count = 0;
  return free;
}

// Until there is room for all or no two have one normal: the last of two becomes part of the first and has no points
// any more. Not the shallowest: which that is changes from step to step on flat ground. Returns how many are left.
int join_surfaces(MeshContact& mc) {
  int left = mc.count;
  for (int i = mc.count - 1; i > 0 && left > kMeshManifolds; --i) {
    Cluster& c = mc.clusters[i];
    int first = 0;
    while (first < i && !one_normal(mc.clusters[first], c.normal)) ++first;
    if (first == i) continue;
    for (int k = 0; k < c.count; ++k) add_point(mc.clusters[first], c.points[k]);
    c.count = 0, --left;
  }
  return left;
}

struct Weights {
  double a, b, c;
};

Weights barycentric(const Triangle& t, const Double3& p) {
  const Double3 ab = wide(t.b) - wide(t.a), ac = wide(t.c) - wide(t.a), ap = p - wide(t.a), n = cross(ab, ac);
  const double nn = dot(n, n), b = dot(n, cross(ap, ac)) / nn, c = dot(n, cross(ab, ap)) / nn;
  return {1 - b - c, b, c};
}

// May the triangle push along `towards` (unit, to the shape) from the point with weights `w`? `face`: its normal on the
// shape's side; `behind`: that side is the back.
bool edge_may_push(const Triangle& t, const Weights& w, const Vec3& face, const Vec3& towards, bool behind) {
  const std::uint32_t flat = behind ? t.flat_edges >> 3 : t.flat_edges;
  const double opposite[3] = {w.c, w.a, w.b};  // weight that vanishes on edge k
  bool on_edge = false, sharp = false;
  Real least = 1;
  for (int k = 0; k < 3; ++k) {
    if (opposite[k] > kOnEdge) continue;
    on_edge = true;
    if (flat >> k & 1u) continue;
    sharp = true;
    least = std::min(least, t.edge_cosine[k]);
  }
  return on_edge && sharp && dot(face, towards) >= least - kVoronoiSlack;
}

// A triangle as one shape sees it, in the frame of that shape.
struct Facing {
  Double3 corner[3];
  Double3 up;   // unit normal of its front
  Double3 low;  // the core's deepest point, towards the triangle's plane from the side where the core's middle is
  bool behind;  // that side is the back
  double gap;   // height of `low` over the triangle; negative: beyond
};

// Does the triangle's plane miss the shape's box in the mesh's frame? Rounding never says so falsely.
bool plane_misses(const MeshContact& mc, const Triangle& t, const Vec3& n) {
  const Vec3 from = mc.middle - t.a;
  const Real reach = std::abs(n[0]) * mc.half[0] + std::abs(n[1]) * mc.half[1] + std::abs(n[2]) * mc.half[2];
  const Real terms = std::abs(n[0] * from[0]) + std::abs(n[1] * from[1]) + std::abs(n[2] * from[2]);
  return std::abs(dot(n, from)) > reach + 16 * kEpsilon * (terms + reach);
}

// False when a plane of the shape's box or of the triangle keeps them apart.
bool near_triangle(const MeshContact& mc, const Triangle& t, Vec3& front, Facing& f) {
  const Vec3 across = cross(t.b - t.a, t.c - t.a);
  if (plane_misses(mc, t, across)) return false;
  const Double3 a = f.corner[0] = mc.pair.from_b(wide(t.a));
  const Double3 b = f.corner[1] = mc.pair.from_b(wide(t.b)), c = f.corner[2] = mc.pair.from_b(wide(t.c));
  const auto apart = [](double p, double q, double r, double from, double to) {
    return std::max(std::max(p, q), r) < from || std::min(std::min(p, q), r) > to;
  };
  if (apart(a.x, b.x, c.x, mc.lo.x, mc.hi.x) || apart(a.y, b.y, c.y, mc.lo.y, mc.hi.y) ||
      apart(a.z, b.z, c.z, mc.lo.z, mc.hi.z))
    return false;
  front = normalized_or(across, vec3(0, 1, 0));
  f.up = mc.pair.from_b(wide(front)) - mc.pair.offset;
  const Double3 high = wide(mc.pair.a.support(narrow(f.up))), low = wide(mc.pair.a.support(narrow(-f.up)));
  const double above = dot(f.up, high - a), below = dot(f.up, low - a);
  f.behind = above + below < 0;
  f.low = f.behind ? high : low;
  f.gap = f.behind ? -above : below;
  return f.gap <= mc.enough;
}

// May a sharp edge push, rather than the face? Not when the deepest point is as far inside as it is deep.
bool edge_in_play(const Triangle& t, const Facing& f) {
  const std::uint32_t flat = f.behind ? t.flat_edges >> 3 : t.flat_edges;
  const double depth = std::max(0.0, -f.gap);
  for (int k = 0; k < 3; ++k) {
    if (flat >> k & 1u) continue;
    const Double3 &from = f.corner[k], along = f.corner[k == 2 ? 0 : k + 1] - from;
    const double inside = dot(cross(f.up, along), f.low - from);  // times the edge's length
    if (!(inside > 0 && inside * inside >= depth * depth * dot(along, along))) return true;
  }
  return false;
}

// The gap straight along the face normal.
Gap face_gap(const Facing& f) {
  Gap gap;
  gap.normal = f.behind ? f.up : -f.up;
  gap.a = f.low;
  gap.distance = f.gap;
  gap.b = gap.a + gap.distance * gap.normal;
  return gap;
}

// Those over the triangle t (`over`; else all), if one is at most at the separation `limit`; else none, and false.
bool add_points(MeshContact& mc, const Patch& patch, const Vec3& normal, std::uint32_t index, const Triangle& t,
                bool over, Real limit) {
  // points from the shape's frame to the mesh's
  ManifoldPoint kept[kMaxPatchPoints];
  int count = 0;
  Real deepest = kInfinity;
  for (int i = 0; i < patch.count; ++i) {
    ManifoldPoint p = patch.points[i];
    p.position = to_world(mc.local, p.position);
    if (over) {
      const Weights w = barycentric(t, wide(p.position));
      if (std::min({w.a, w.b, w.c}) < -1e-3) continue;  // over a neighbour, which takes it
    }
    p.feature = (p.feature ^ index * 2654435761u) * 16777619u;
    deepest = std::min(deepest, p.separation);
    kept[count++] = p;
  }
  if (count == 0 || deepest > limit) return false;
  Cluster* cluster = cluster_for(mc, normal, t.surface, deepest);
  if (!cluster) return true;
  for (int i = 0; i < count; ++i) add_point(*cluster, kept[i]);
  return true;
}

void collide_triangle(MeshContact& mc, std::uint32_t index) {
  const Triangle& t = mc.mesh.triangle(index);
  Vec3 front;
  Facing facing;
  if (!near_triangle(mc, t, front, facing)) return;
  const Vec3 face = facing.behind ? Vec3(-front) : front;
  const Vec3 corners[3] = {t.a, t.b, t.c};
  mc.pair.b.points = corners;
  Gap nearest;
  bool edge = false;
  Real face_limit = kInfinity;
  Vec3 towards = face;
  if (edge_in_play(t, facing)) {
    if (!core_gap(mc.pair, facing.behind ? -facing.up : facing.up, mc.enough, nearest)) return;
    towards = -rotate(mc.local.rotation, narrow(nearest.normal));
    const Weights w = barycentric(t, wide(to_world(mc.local, narrow(nearest.b))));
    edge = edge_may_push(t, w, face, towards, facing.behind);
    if (edge) face_limit = Real(nearest.distance) - mc.pair.a.radius + kShallower * mc.margin;
  }
  Patch patch;
  if (!edge || dot(towards, face) >= kFaceCosine) {
    contact_patch(mc.pair, face_gap(facing), mc.margin, patch);
    if (add_points(mc, patch, -face, index, t, true, face_limit) || !edge) return;
  }
  // the deepest is beside the triangle, perhaps hardly: across a border or a blunt ridge no neighbour takes it
  contact_patch(mc.pair, nearest, mc.margin, patch);
  add_points(mc, patch, rotate(mc.local.rotation, patch.normal), index, t, false, kInfinity);
}

int convex_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                Manifold* out) {
  const Pose local{to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation};
  Aabb box = a.bounds(local);
  box.grow(margin);
  MeshContact mc(a, b, local, margin);
  mc.middle = (box.lo + box.hi) / 2, mc.half = (box.hi - box.lo) / 2;
  const auto visit = [](void* context, std::uint32_t i) { collide_triangle(*static_cast<MeshContact*>(context), i); };
  b.triangles_in(box, visit, &mc);

  // the deepest clusters, in the order they were found
  bool taken[kClusters] = {};
  const int left = join_surfaces(mc);
  for (int found = 0; found < kMeshManifolds && found < left; ++found) {
    int best = -1;
    for (int i = 0; i < mc.count; ++i)
      if (!taken[i] && mc.clusters[i].count > 0 && (best < 0 || mc.clusters[i].deepest < mc.clusters[best].deepest))
        best = i;
    taken[best] = true;
  }
  const Mat3 r = to_matrix(pose_b.rotation);
  int count = 0;
  for (int i = 0; i < mc.count; ++i) {
    if (!taken[i]) continue;
    Manifold& m = out[count++];
    reduce_points({mc.clusters[i].points, static_cast<std::size_t>(mc.clusters[i].count)}, mc.clusters[i].normal, m);
    m.normal = r * mc.clusters[i].normal;
    m.surface = mc.clusters[i].surface;
    for (int k = 0; k < m.count; ++k) m.points[k].position = pose_b.position + r * m.points[k].position;
  }
  return count;
}

}  // namespace

PairRow narrow_convex_mesh() { return {"convex", "mesh", convex_mesh}; }

}  // namespace feder
