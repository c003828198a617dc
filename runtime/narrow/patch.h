// From the gap of two convex cores to a manifold: which faces look at each other, and where they overlap.
#pragma once
#include "narrow/gjk.h"
#include "narrow/manifold.h"

namespace feder {

inline constexpr int kMaxPatchPoints = 2 * kMaxFacePoints + 1;

struct Patch {
  Patch() {}
  Vec3 normal;    // unit, from a to b
  int count = 0;  // points with separation <= margin, not reduced
  union {         // not filled before use
    ManifoldPoint points[kMaxPatchPoints];
  };
  std::uint8_t reference = 0;  // 1: points lie on a face of a; 2: of b; 0: edges or a single point
};

// Everything in the frame of a. Has at least one point when the gap, minus the radii, is within the margin.
void contact_patch(const ConvexPair& pair, const Gap& gap, Real margin, Patch& patch);
// Its four points, in the world: 1, the count of manifolds.
int gap_manifold(const ConvexPair& pair, const Gap& gap, Real margin, const Pose& pose_a, Manifold& out);

}  // namespace feder
