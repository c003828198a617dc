// Any convex shape against a triangle mesh. Each triangle near the shape is tested alone (GJK, EPA); the seams between
// triangles must not be felt. So a triangle pushes along its own normal, on the side where the shape's middle is, and
// only where the shape is over it; an edge or a corner may push along another direction only when it is sharp (its
// neighbours fall away), and only as far round as the neighbour's normal. Points with nearly one normal form one
// manifold; of these the deepest kMaxManifolds are returned. Triangles come in ascending order: deterministic.
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
constexpr int kClusters = 8;
constexpr int kClusterPoints = 24;

struct Cluster {
  Vec3 normal;  // from the shape to the mesh, in the mesh's frame
  Real deepest = kInfinity;
  int count = 0;
  ManifoldPoint points[kClusterPoints];
};

struct MeshContact {
  const Convex& convex;
  const Shape& mesh;
  const Pose& local;  // the shape in the frame of the mesh
  Real margin;
  int count = 0;
  Cluster clusters[kClusters];
};

void reduce_cluster(Cluster& c) {
  Manifold m;
  reduce_points({c.points, static_cast<std::size_t>(c.count)}, c.normal, m);
  c.count = m.count;
  for (int i = 0; i < m.count; ++i) c.points[i] = m.points[i];
}

// The cluster for `normal`, or a new one; when full, the shallowest is given up if this is deeper.
Cluster* cluster_for(MeshContact& mc, const Vec3& normal, Real deepest) {
  for (int i = 0; i < mc.count; ++i)
    if (dot(mc.clusters[i].normal, normal) > kClusterCosine) return &mc.clusters[i];
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
  free->deepest = kInfinity;
  free->count = 0;
  return free;
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

// The gap straight along the face normal.
Gap face_gap(const ConvexPair& pair, const Triangle& t, const Vec3& face) {
  Gap gap;
  gap.normal = pair.from_b(-wide(face)) - pair.offset;
  gap.a = wide(pair.a.support(narrow(gap.normal)));
  gap.distance = dot(gap.normal, pair.from_b(wide(t.a)) - gap.a);
  gap.b = gap.a + gap.distance * gap.normal;
  return gap;
}

void add_points(MeshContact& mc, const Patch& patch, const Vec3& normal, std::uint32_t index, const Triangle* over) {
  // points from the shape's frame to the mesh's
  ManifoldPoint kept[kMaxPatchPoints];
  int count = 0;
  Real deepest = kInfinity;
  for (int i = 0; i < patch.count; ++i) {
    ManifoldPoint p = patch.points[i];
    p.position = to_world(mc.local, p.position);
    if (over) {
      const Weights w = barycentric(*over, wide(p.position));
      if (std::min({w.a, w.b, w.c}) < -1e-3) continue;  // over a neighbour, which takes it
    }
    p.feature = (p.feature ^ index * 2654435761u) * 16777619u;
    deepest = std::min(deepest, p.separation);
    kept[count++] = p;
  }
  if (count == 0) return;
  Cluster* cluster = cluster_for(mc, normal, deepest);
  if (!cluster) return;
  if (deepest < cluster->deepest) cluster->deepest = deepest;
  for (int i = 0; i < count; ++i) {
    if (cluster->count == kClusterPoints) reduce_cluster(*cluster);
    cluster->points[cluster->count++] = kept[i];
  }
}

void collide_triangle(MeshContact& mc, std::uint32_t index) {
  const Triangle t = mc.mesh.triangle(index);
  const Vec3 corners[3] = {t.a, t.b, t.c};
  const Vec3 front = normalized_or(cross(t.b - t.a, t.c - t.a), vec3(0, 1, 0));
  const ConvexPair pair(mc.convex, mc.local, Convex(corners, 3), Pose{});
  const Double3 up = pair.from_b(wide(front)) - pair.offset, at = pair.from_b(wide(t.a));

  // which side of the triangle the shape's middle is on
  const Double3 high = wide(pair.a.support(narrow(up))), low = wide(pair.a.support(narrow(-up)));
  const bool behind = dot(up, 0.5 * (high + low) - at) < 0;
  const Vec3 face = behind ? Vec3(-front) : front;
  const double enough = double(mc.margin) + mc.convex.radius;
  if (dot(up, behind ? at - high : low - at) > enough) return;

  Gap gap;
  if (!core_gap(pair, -pair.offset, enough, gap)) return;
  const Vec3 towards = -rotate(mc.local.rotation, narrow(gap.normal));
  Patch patch;
  const Weights w = barycentric(t, wide(to_world(mc.local, narrow(gap.b))));
  if (dot(towards, face) < kFaceCosine && edge_may_push(t, w, face, towards, behind)) {
    contact_patch(pair, gap, mc.margin, patch);
    add_points(mc, patch, rotate(mc.local.rotation, patch.normal), index, nullptr);
    return;
  }
  gap = face_gap(pair, t, face);
  if (gap.distance > enough) return;
  contact_patch(pair, gap, mc.margin, patch);
  add_points(mc, patch, -face, index, &t);
}

int convex_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
                Manifold* out) {
  const Pose local{to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation};
  Aabb box = a.bounds(local);
  box.grow(margin);
  const Convex convex(a);
  MeshContact mc{convex, b, local, margin, 0, {}};
  const auto visit = [](void* context, std::uint32_t i) { collide_triangle(*static_cast<MeshContact*>(context), i); };
  b.triangles_in(box, visit, &mc);

  // the deepest clusters, in the order they were found
  bool taken[kClusters] = {};
  int found = 0;
  for (; found < kMaxManifolds && found < mc.count; ++found) {
    int best = -1;
    for (int i = 0; i < mc.count; ++i)
      if (!taken[i] && (best < 0 || mc.clusters[i].deepest < mc.clusters[best].deepest)) best = i;
    taken[best] = true;
  }
  const Mat3 r = to_matrix(pose_b.rotation);
  int count = 0;
  for (int i = 0; i < mc.count; ++i) {
    if (!taken[i]) continue;
    Manifold& m = out[count++];
    reduce_points({mc.clusters[i].points, static_cast<std::size_t>(mc.clusters[i].count)}, mc.clusters[i].normal, m);
    m.normal = r * mc.clusters[i].normal;
    for (int k = 0; k < m.count; ++k) m.points[k].position = pose_b.position + r * m.points[k].position;
  }
  return count;
}

}  // namespace

PairRow narrow_convex_mesh() { return {"convex", "mesh", convex_mesh}; }

}  // namespace feder
