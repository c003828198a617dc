// Distance and overlap depth of two convex cores through their support functions (internal to narrow).
// All points and normals are in the frame of a.
#pragma once
#include "base/double3.h"
#include "feder/shape.h"

namespace feder {

// A convex shape, or a few loose points (the triangle of a mesh).
struct Convex {
  explicit Convex(const Shape& s) : shape(&s), radius(s.radius()) {}
  Convex(const Vec3* p, int n) : points(p), count(n) {}

  const Shape* shape = nullptr;
  const Vec3* points = nullptr;
  int count = 0;
  Real radius = 0;
  Real scale = 1;  // of a shape, about `center`; its radius is scaled by hand
  Vec3 center = Vec3::Zero();

  Vec3 support(const Vec3& direction) const;
  int face(const Vec3& direction, Vec3* out) const;  // as Shape::face; loose points: all of them
};

// b placed in the frame of a.
struct ConvexPair {
  ConvexPair(const Convex& a, const Pose& pose_a, const Convex& b, const Pose& pose_b);

  Convex a, b;
  Double3 row[3];  // rotation from b to a
  Double3 offset;  // origin of b in a

  Double3 from_b(const Double3& p) const { return offset + Double3{dot(row[0], p), dot(row[1], p), dot(row[2], p)}; }
  Double3 direction_to_b(const Double3& d) const { return d.x * row[0] + d.y * row[1] + d.z * row[2]; }
};

// A point of the Minkowski difference a - b, and where it comes from.
struct Difference {
  Double3 w, a, b;
};
Difference support(const ConvexPair& pair, const Double3& direction);

struct Simplex {
  Difference v[4];
  double weight[4];  // of the nearest point
  int count = 0;     // in use
};

struct Gap {
  double distance = 0;  // between the cores; negative: depth of the overlap
  Double3 a{}, b{};     // nearest points of the cores (overlap: the deepest ones)
  Double3 normal{};     // unit, from a to b
};

// True when the cores are apart: `gap` is filled. Else `simplex` holds the origin, to rounding. `start`: a guess of
// the direction from b to a. Stops early with distance = lower bound when that exceeds `enough`.
bool gjk_distance(const ConvexPair& pair, const Double3& start, double enough, Simplex& simplex, Gap& gap);

// Depth of an overlap, from the simplex of gjk_distance.
Gap epa_depth(const ConvexPair& pair, const Simplex& simplex);

// Both in one: the gap of two cores. False when it surely exceeds `enough`.
bool core_gap(const ConvexPair& pair, const Double3& start, double enough, Gap& gap);

}  // namespace feder
