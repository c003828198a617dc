// Narrow phase: two shapes at two poses -> manifolds. The table of pair tests is generated from the
// feder_pair(a b) lines; a pair without a line of its own uses the generic convex test (GJK/EPA + face clipping).
// Contract, checked for every pair of shape kinds by tests/narrow/test_pair_contract.cpp:
//  - points with separation <= margin are found; none with separation > margin is returned;
//  - swapping the shapes gives the same manifold with the opposite normal;
//  - normal and depth agree with GJK/EPA; pushing apart by the depth along the normal separates to 1e-4 sizes;
//  - pure: no state but `cache`, and the cache changes the cost, not the result beyond rounding.
#pragma once
#include <span>

#include "feder/shape.h"
#include "narrow/manifold.h"

namespace feder {

// Writes up to kMaxManifolds manifolds, returns how many have points.
using PairTest = int (*)(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin,
                         PairCache& cache, Manifold* out);

struct PairRow {
  const char* kind_a;
  const char* kind_b;
  PairTest test;
};
std::span<const PairRow> pair_tests();

// Dispatch tables by kind_id, built once per world. `algorithm`: "auto" (special pair tests, then generic) or "gjk"
// (generic everywhere it can).
class NarrowPhase {
 public:
  explicit NarrowPhase(const std::string& algorithm, std::span<const PairRow> tests = pair_tests());
  int collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache& cache,
              Manifold* out) const;

  // Should they touch, but this build has no test for them? Never of planes and meshes among themselves, and of 2D
  // sections and solids.
  bool lacks(const Shape& a, const Shape& b) const;
  bool complete() const { return complete_; }  // lacks no pair of kinds

 private:
  struct Entry {
    PairTest test = nullptr;
    bool swapped = false;
    bool lacking = false;
  };
  int kinds_;
  bool complete_ = true;
  std::vector<Entry> table_;  // kinds x kinds
};

struct ClosestResult {
  Real distance = 0;      // between the rounded surfaces; 0 when overlapping
  Vec3 point_a, point_b;  // world, on the surfaces
  Vec3 normal;            // unit, a to b
};
// GJK between two convex shapes (radii included).
ClosestResult closest_points(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

// Do two shapes of any kind overlap? (queries and sensors)
bool shapes_overlap(const NarrowPhase& narrow, const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

struct CastHit {
  Real fraction = 1;
  Vec3 point = Vec3::Zero();   // world
  Vec3 normal = Vec3::Zero();  // on b, unit
};
// Sweeps convex `a` by `motion` (no rotation) against b: conservative advancement. False when it never touches.
bool shape_cast(const Shape& a, const Pose& pose_a, const Vec3& motion, const Shape& b, const Pose& pose_b,
                CastHit& hit);

}  // namespace feder
