// Proximity search of one group of surfaces: candidate pairs of features, boxes and trees. Private to the module.
#pragma once
#include "bounds/box_tree.h"
#include "contact/near_batch.h"
#include "state/surface.h"

namespace feder {

constexpr Real kMaxDeviation =
    Real(0.25);  // thicknesses that a point may deviate from the motion that a search extrapolated

// Candidate pair of this step: a point and a triangle, or two edges.
struct NearPair {
  std::uint32_t v[4] = {};             // the point and the corners of the triangle; or the ends of both edges
  std::uint32_t edges = 0;             // 1: edge and edge
  Real thickness = 0;                  // distance that rows keep, m; less where they are closer at rest
  Vec3 normal = Vec3::Zero();          // of this part, from the second feature to the first
  Real distance = 0;                   // at its start, m
  std::uint32_t surface_pair = kNone;  // in Surfaces::pairs; kNone: of one surface
  Real idle = 0;                       // s since the search, before which it cannot come within its thickness
  Real spare = 0;                      // distance at the search less what makes a row, m
  Real weight[4] = {};                 // of the points in the gap, at the start of this part
  std::uint32_t live = 0;              // 1: it may come within its thickness in this part
};

// What a kept search is of: its candidates hold while nothing of this changes.
struct KeptOf {
  ObjectId object;
  std::uint64_t version = 0;
  std::uint32_t group = 0, surface = 0, first = 0, count = 0;
  Real thickness = 0;
  friend bool operator==(const KeptOf&, const KeptOf&) = default;
};

// All of it is made anew in each step, but for a kept search (kept.cpp).
struct NearSearch {
  explicit NearSearch(Arena& a)
      : pairs(&a), offered(&a), which(&a), near_vertex(&a), near_point(&a), near_triangle(&a), near_edge(&a),
        triangle_box(&a), edge_box(&a), triangle_tree(a), edge_tree(a), rest(&a), batches(&a), given(&a) {}

  bool near = false;   // its surfaces may be in contact, so that it searches at all
  int near_every = 1;  // solver substeps from one update of rows and normals to the next
  Array<NearPair> pairs;
  Array<NearPair> offered;                        // pairs of features that a search has not tested yet
  Array<std::uint32_t> which;                     // some of either
  Array<std::uint32_t> near_vertex;               // points of the surfaces that take part
  Array<std::uint32_t> near_point;                // those of them that may be in contact
  Array<std::uint32_t> near_triangle, near_edge;  // three and two points per item of the trees
  Array<Aabb> triangle_box, edge_box;             // swept over the rest of the step, relative to the drift
  BoxTree triangle_tree, edge_tree;
  Vec3 drift = Vec3::Zero();  // mean velocity of surfaces without pins, m/s; else zero
  Real since_found = 0;       // s, since the boxes were made
  bool pairs_stale = true;    // motion has left what the search extrapolated
  bool trees_stale = true;    // none were built in this step

  bool kept = false;    // points were taken to rest where the search found them: its candidates hold over steps
  bool listed = false;  // those candidates are in `pairs`; else they follow from `rest`
  KeptOf kept_of;
  Array<Row4> rest;  // by point of the surface: position then, m, and how far it may go from there, m

  // The group's near_rows in batches, and in each by bits those that gave an impulse since they were made.
  Array<RowBatch> batches;
  Array<unsigned char> given;

  void begin() {  // of a step
    trees_stale = true;
    batches.clear(), given.clear();
    if (!kept) pairs.clear(), pairs_stale = true;
  }
  void drop() {
    pairs.clear();
    pairs_stale = true, kept = listed = false;
  }
};

}  // namespace feder
