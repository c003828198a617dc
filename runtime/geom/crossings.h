// Crossings of a triangle mesh with itself: its edges that pass through triangles with which they share no vertex
// (geom/predicates.h says what touching counts as). Candidates come from a hierarchy of the triangles' boxes. Kept
// between calls: memory. tests/geom/test_crossings.cpp.
#pragma once
#include <span>

#include "bounds/box_tree.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

struct Crossing {
  std::uint32_t edge = 0, triangle = 0;
  friend bool operator==(const Crossing&, const Crossing&) = default;
};

// The two ends of an edge lie together, those of the next `stride` numbers on.
struct CrossingMesh {
  std::span<const Vec3> points;
  std::span<const std::uint32_t> triangles;  // three points each
  const std::uint32_t* ends = nullptr;
  std::uint32_t stride = 2, edges = 0;
  const std::uint32_t* edge(std::uint32_t e) const { return ends + std::size_t(stride) * e; }
};

class CrossingSearch {
 public:
  explicit CrossingSearch(Arena& a) : tree_(a), chosen_(&a), box_(&a) {}
  // All crossings of which both features meet `where`, by ascending edge, then triangle; replaces `out`. Ends after the
  // edge with which there are more than `most`.
  void find(const CrossingMesh& mesh, const Aabb& where, Array<Crossing>& out, std::size_t most = std::size_t(-1));

 private:
  BoxTree tree_;
  Array<std::uint32_t> chosen_;
  Array<Aabb> box_;
};

// Bounds of a mesh's points, for `where`.
Aabb bounds_of(std::span<const Vec3> points);

}  // namespace feder
