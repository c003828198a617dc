// Proximity search of one group of surfaces: candidate pairs of features, boxes and trees. Private to the module.
#pragma once
#include "bounds/box_tree.h"
#include "contact/near_batch.h"
#include "state/surface.h"

namespace feder {

constexpr Real kMaxDeviation =
    Real(0.25);  // thicknesses that a point may deviate from the motion that a search extrapolated

// Thicknesses below which a pair gets a row.
constexpr Real kNear = Real(1.1);

// Candidate pair: a point and a triangle, or two edges.
struct NearCandidate {
  std::uint32_t v[4] = {};             // the point and the corners of the triangle; or the ends of both edges
  std::uint32_t edges = 0;             // 1: edge and edge
  std::uint32_t surface_pair = kNone;  // in Surfaces::pairs; kNone: of one surface
  Real thickness = 0;                  // distance that rows keep, m; less where they are closer at rest
  Real spare = 0;                      // distance at the search less what makes a row, m
  Real idle = 0;                       // s since the search, before which it cannot come within its thickness
};

// A candidate that may come within its thickness in this part.
struct NearPair {
  NearPair() = default;
  explicit NearPair(const NearCandidate& c) : edges(c.edges), surface_pair(c.surface_pair), thickness(c.thickness) {
    for (int k = 0; k < 4; ++k) v[k] = c.v[k];
  }
  std::uint32_t v[4] = {};
  std::uint32_t edges = 0;
  std::uint32_t surface_pair = kNone;
  Real thickness = 0;
  Real distance = 0;           // at the start of the part, m
  Vec3 normal = Vec3::Zero();  // likewise, from the second feature to the first
  Real weight[4] = {};         // of the points in the vector between them
};

// What a kept search is of: its candidates hold while nothing of this changes.
struct KeptOf {
  ObjectId object;
  std::uint64_t version = 0;
  std::uint32_t group = 0, surface = 0, first = 0, count = 0;
  double thickness = 0;  // m
  friend bool operator==(const KeptOf&, const KeptOf&) = default;
};
static_assert(sizeof(KeptOf) == 40);  // no gaps: it is saved as it is

// All of it is made anew in each step, but for a kept search (kept.cpp).
struct NearSearch {
  explicit NearSearch(Arena& a)
      : candidates(&a), pairs(&a), offered(&a), which(&a), near_vertex(&a), near_point(&a), near_triangle(&a),
        near_edge(&a), triangle_box(&a), edge_box(&a), triangle_tree(a), edge_tree(a), rest(&a), meetings(&a),
        old_meetings(&a), old_candidates(&a), old_of(&a), next_old(&a), again(&a), batches(&a), given(&a) {}

  bool near = false;   // its surfaces may be in contact, so that it searches at all
  int near_every = 1;  // solver substeps from one update of rows and normals to the next
  Array<NearCandidate> candidates;
  Array<NearPair> pairs;                          // those of them that may come near in this part
  Array<NearCandidate> offered;                   // pairs of features that a search has not tested yet
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

  bool kept = false;       // points were taken to rest where the search found them: its candidates hold over steps
  std::uint32_t rows = 0;  // that they made in the last part
  bool listed = false;     // those candidates are in `candidates`; else they follow from `rest`
  KeptOf kept_of;
  Array<Row4> rest;  // by point of the surface: position then, m, and how far it may go from there, m
  // Its candidates by pairs of blocks of flat_parts.h, and those of the search before while it is done again in part.
  struct Meeting {
    std::uint32_t a = 0, b = 0, first = 0, last = 0;  // candidates first .. last - 1
  };
  Array<Meeting> meetings, old_meetings;
  Array<NearCandidate> old_candidates;
  Array<std::uint32_t> old_of, next_old;  // by block: the first of old_meetings with it as `a`; the next one
  Array<unsigned char> again;             // by block: 1: it is searched again

  // The group's near_rows in batches, and in each by bits those that gave an impulse since they were made.
  Array<RowBatch> batches;
  Array<unsigned char> given;

  void begin() {  // of a step
    trees_stale = true;
    batches.clear(), given.clear();
    pairs.clear();
    if (!kept) candidates.clear(), pairs_stale = true, rows = 0;
  }
  void drop() {
    candidates.clear(), pairs.clear();
    pairs_stale = true, kept = listed = false, rows = 0;
  }
};

}  // namespace feder
