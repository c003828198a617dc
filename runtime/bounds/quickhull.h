// Convex hull of a point cloud: corners and polygonal faces.
#pragma once
#include <span>
#include <vector>

#include "feder/types.h"

namespace feder {

inline constexpr int kMaxHullCorners = 256;

struct HullFace {
  Vec3 normal = Vec3::Zero();  // unit, outward
  Real offset = 0;             // normal . x = offset on the face
  std::uint16_t first = 0;     // in Hull::loops
  std::uint16_t count = 0;     // corners, counter-clockwise seen from outside
};

// What quickhull finds; a plain value.
struct HullData {
  std::vector<Vec3> corners;
  std::vector<HullFace> faces;
  std::vector<std::uint16_t> loops;  // corner numbers of the faces, one after another
  const Vec3& corner(const HullFace& f, int i) const { return corners[loops[f.first + static_cast<std::size_t>(i)]]; }
};

// SceneError when the points are too few, not finite, flat, or span too many corners.
HullData build_hull(std::span<const Vec3> points);

}  // namespace feder
