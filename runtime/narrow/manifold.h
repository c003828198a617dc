// What two touching shapes share: up to four points with one normal.
#pragma once
#include "feder/types.h"

namespace feder {

inline constexpr int kMaxManifoldPoints = 4;
// Per pair of colliders: one of convex shapes, four against meshes, eight against distance fields.
inline constexpr int kMeshManifolds = 4, kMaxManifolds = 8;

struct ManifoldPoint {
  Vec3 position = Vec3::Zero();  // world, midway between the surfaces, m
  Real separation = 0;           // along the normal, negative when overlapping, m
  std::uint32_t feature = 0;     // same features in two steps = same point (edges, vertices of both shapes)
};

struct Manifold {
  Vec3 normal = Vec3::Zero();  // unit, world, from a to b
  int count = 0;               // points in use; 0 = apart by more than the margin
  SurfaceNumber surface = 0;   // of the mesh's triangles that it is on
  ManifoldPoint points[kMaxManifoldPoints];
};

// What a pair test may keep between steps to start from (separating axis, GJK simplex). Zeroed for a new pair.
struct PairCache {
  std::uint32_t word[2] = {0, 0};
};

}  // namespace feder
