// Narrow phase: two shapes at two poses -> manifolds. The table of pair tests is generated from the
// feder_pair(a b) lines; a pair without a line of its own uses the generic convex test (GJK/EPA + face clipping).
// Contract, checked for every pair of shape kinds by tests/narrow/test_pair_contract.cpp:
//  - points with separation <= margin are found; none with separation > margin is returned;
//  - swapping the shapes gives the same manifold with the opposite normal;
//  - normal and depth agree with GJK/EPA; pushing apart by the depth along the normal separates to 1e-4 sizes;
//  - pure: no state but `cache`, and the cache changes the cost, not the result beyond rounding.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

// The distance of two cores as a method finds it, and how.
struct CoreDistance {
  bool overlap = false;
  double distance = 0;     // m, when apart
  int steps = 0;           // of its search
  bool repeat = false;     // it went in a circle
  bool handed_on = false;  // for that or another reason GJK has answered
};

// A narrow phase by name: its tests take the place of those of "auto".
struct NarrowMethod {
  const char* name;
  const char* summary;
  std::vector<PairRow> pairs;
  void (*prepare)(const Shape&);  // before a shape's first test: what it keeps with shapes
  // False for shapes that it has no test for. Uses the cache as its tests do.
  bool (*distance)(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, PairCache& cache,
                   CoreDistance& out);
  std::size_t (*bytes)(const Shape&);            // kept with a shape
  std::uint32_t (*handed_on)(const PairCache&);  // how often a pair was, up to 127
};
std::span<const NarrowMethod> narrow_methods();
std::string narrow_phase_names();  // "auto, gjk, ..."

// Dispatch tables by kind_id, built once per world. `algorithm`: "auto" (special pair tests, then generic), "gjk"
// (generic everywhere it can), or a method by name (its tests, then those of "auto").
class NarrowPhase {
 public:
  explicit NarrowPhase(const std::string& algorithm, std::span<const PairRow> tests = pair_tests());
  void prepare(const Shape& shape) const {
    if (method_) method_->prepare(shape);
  }
  const NarrowMethod* method() const { return method_; }
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
  void take(const PairRow& row, bool generic, int wanted);
  int kinds_;
  const NarrowMethod* method_ = nullptr;
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
