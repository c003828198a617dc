// A group of cloths that share their substeps: what one of them does in a substep may reach the others within it.
// Private to the module.
#pragma once
#include "bounds/box_tree.h"
#include "cloth/cloth.h"

namespace feder {

constexpr Real kStray = Real(0.25);  // thicknesses, by which a vertex may leave the way that a search foresaw

// Two features that may come close in this step: a vertex and a triangle, or two edges.
struct NearPair {
  std::uint32_t v[4] = {};        // vertex and the triangle's three; or two and two
  std::uint32_t edges = 0;        // 1: edge and edge
  Real thickness = 0;             // wanted distance, m; less where they are closer at rest
  Vec3 normal = Vec3::Zero();     // of this part, from the second feature to the first
  Real distance = 0;              // at its start, m
  std::uint32_t between = kNone;  // of two cloths
  Real idle = 0;                  // s since the search, for which it cannot come close
  std::uint32_t live = 0;         // 1: it may come close in this part
};

struct ClothGroup {
  explicit ClothGroup(Arena& a)
      : sheets(&a), rows(&a), near_rows(&a), holds(&a), named(&a), movers(&a), pairs(&a), near_vertex(&a),
        near_triangle(&a), near_edge(&a), triangle_box(&a), edge_box(&a), triangle_tree(a), edge_tree(a) {}

  // of a step
  Array<std::uint32_t> sheets;  // ascending; the first names the group
  int steps = 0;                // substeps in a substep of the world; 0: none of them moves
  Real step = 0;                // s, of one
  // of a substep
  Array<ClothRow> rows;       // of couplings
  Array<ClothRow> near_rows;  // of cloth against cloth
  Array<ClothHold> holds;
  Array<std::uint32_t> named;   // solver indices of what they may touch or hang on, by couplings
  Array<std::uint32_t> movers;  // the same, each once
  std::size_t own_rows = 0;     // links and hinges of the cloths that move
  bool near = false;            // cloth may touch cloth
  bool crowded = false;         // and does, in this substep
  int near_every = 1;           // substeps from one search for what is near to the next

  // closeness of cloth and cloth; all of it is found anew in each step
  Array<NearPair> pairs;
  Array<std::uint32_t> near_vertex;               // of the cloths that take part
  Array<std::uint32_t> near_triangle, near_edge;  // three and two vertices per item of the trees
  Array<Aabb> triangle_box, edge_box;             // swept over the rest of the step, beside the drift
  BoxTree triangle_tree, edge_tree;
  Vec3 drift = Vec3::Zero();  // mean velocity of free cloths, m/s
  Real since_found = 0;       // s, since the boxes were made
  bool pairs_stale = true;    // motion is not what it was at the search
  bool trees_stale = true;    // of this step there are none

  void begin() {  // of a step
    sheets.clear(), pairs.clear(), rows.clear(), near_rows.clear(), holds.clear(), named.clear();
    steps = 0, step = 0;
    pairs_stale = trees_stale = true;
  }
  bool touches() const { return !rows.empty() || !holds.empty() || !near_rows.empty(); }
};

}  // namespace feder
