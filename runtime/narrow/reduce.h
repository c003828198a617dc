// From many contact points to the four that carry the pair.
#pragma once
#include <span>

#include "narrow/manifold.h"

namespace feder {

// Keeps the deepest point (the first one within a small tolerance, so that equal depths do not flicker) and those
// that span the largest area across `normal`. Overwrites out; the order of the points kept is deterministic.
void reduce_points(std::span<const ManifoldPoint> points, const Vec3& normal, Manifold& out);

// The same on indices: fills chosen[kMaxManifoldPoints], returns the count.
int reduce_indices(std::span<const ManifoldPoint> points, const Vec3& normal, int* chosen);

// An id for a point that is fixed in a shape's frame: its coordinates, hashed.
std::uint32_t feature_of(const Vec3& local);

}  // namespace feder
