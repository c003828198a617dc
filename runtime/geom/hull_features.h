// The boundary of a convex polytope as a graph of its features (vertices, edges, faces), for marching from one to the
// next. Made on demand: who asks for none has none.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/double3.h"
#include "bounds/quickhull.h"

namespace feder {

struct FeatureEdge {
  std::uint16_t tail, head;
  std::uint16_t left, right;  // faces, seen from outside
  Double3 direction;          // unit, tail to head
};

struct FeatureFace {
  Double3 normal;  // unit, outward
  double offset;
  std::uint16_t first, count;  // in `loops`
};

// An edge with its sense: edge << 1, | 1 when it is met from its head.
using EdgeUse = std::uint16_t;

// Views into one graph. A loop runs counter-clockwise seen from outside; the spokes of a vertex lead away from it.
struct Features {
  std::span<const Double3> vertices;
  std::span<const FeatureEdge> edges;
  std::span<const FeatureFace> faces;
  std::span<const EdgeUse> loops, spokes;
  std::span<const std::uint16_t> first_spoke;  // one per vertex, and the end
  double reach = 0;                            // largest coordinate
  double size = 0;                             // diagonal of the bounding box
  bool bent = false;                           // faces that are not flat, or edges that are not convex, to kBent

  std::span<const EdgeUse> loop(const FeatureFace& f) const { return loops.subspan(f.first, f.count); }
  std::span<const EdgeUse> spokes_of(std::size_t v) const {
    return spokes.subspan(first_spoke[v], static_cast<std::size_t>(first_spoke[v + 1] - first_spoke[v]));
  }
  std::uint16_t far_end(EdgeUse use) const { return use & 1 ? edges[use >> 1].tail : edges[use >> 1].head; }
};

inline constexpr double kBent = 2e-7;  // of the size

class FeatureGraph {
 public:
  FeatureGraph(std::vector<Double3> vertices, std::span<const HullFace> faces, std::span<const std::uint16_t> loops);
  // Empty where the faces do not close.
  const Features& view() const { return view_; }
  std::size_t bytes() const;

 private:
  bool close(std::span<const HullFace> faces, std::span<const std::uint16_t> loops);
  void set_planes();
  void measure();
  std::vector<Double3> vertices_;
  std::vector<FeatureEdge> edges_;
  std::vector<FeatureFace> faces_;
  std::vector<EdgeUse> loops_, spokes_;
  std::vector<std::uint16_t> first_spoke_;
  Features view_;
};

}  // namespace feder
