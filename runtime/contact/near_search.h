// What the search for closeness keeps of one group of surfaces. Private to the module.
#pragma once
#include "bounds/box_tree.h"
#include "state/surface.h"

namespace feder {

constexpr Real kStray = Real(0.25);  // thicknesses, by which a point may leave the way that a search foresaw

// Two features that may come close in this step: a point and a triangle, or two edges.
struct NearPair {
  std::uint32_t v[4] = {};        // point and the triangle's three; or two and two
  std::uint32_t edges = 0;        // 1: edge and edge
  Real thickness = 0;             // wanted distance, m; less where they are closer at rest
  Vec3 normal = Vec3::Zero();     // of this part, from the second feature to the first
  Real distance = 0;              // at its start, m
  std::uint32_t between = kNone;  // in Surfaces::pairs; kNone: of one surface
  Real idle = 0;                  // s since the search, for which it cannot come close
  std::uint32_t live = 0;         // 1: it may come close in this part
};

// All of it is found anew in each step.
struct NearSearch {
  explicit NearSearch(Arena& a)
      : pairs(&a), near_vertex(&a), near_triangle(&a), near_edge(&a), triangle_box(&a), edge_box(&a), triangle_tree(a),
        edge_tree(a) {}

  bool near = false;   // its surfaces may touch
  int near_every = 1;  // substeps from one search for what is near to the next
  Array<NearPair> pairs;
  Array<std::uint32_t> near_vertex;               // of the surfaces that take part
  Array<std::uint32_t> near_triangle, near_edge;  // three and two points per item of the trees
  Array<Aabb> triangle_box, edge_box;             // swept over the rest of the step, beside the drift
  BoxTree triangle_tree, edge_tree;
  Vec3 drift = Vec3::Zero();  // mean velocity of free surfaces, m/s
  Real since_found = 0;       // s, since the boxes were made
  bool pairs_stale = true;    // motion is not what it was at the search
  bool trees_stale = true;    // of this step there are none

  void begin() {  // of a step
    pairs.clear();
    pairs_stale = trees_stale = true;
  }
};

}  // namespace feder
