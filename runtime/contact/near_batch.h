// Pairs of features and contact rows between surfaces, eight to a batch, and kernels for them: closest points, which
// pairs may come near, which rows are closed. Plain structs only: included by the file that is compiled with -mavx2.
// Private to the module.
#pragma once
#include "base/simd.h"

namespace feder {

// Of a SurfaceRow what its gap takes. Empty lanes have weights of zero and a positive offset.
struct RowBatch {
  unsigned v[4][kLanes];
  Lane8 weight[4];
  Lane8x3 normal;
  Lane8 offset;
};

// Pairs of one kind: points and triangles, or edges and edges. Empty lanes repeat a pair.
struct PairBatch {
  unsigned v[4][kLanes];
  Lane8 wanted;  // of a search: distance below which a pair gets a row, m
  // results
  Lane8 weight[4];  // of the points in the vector from the closest point of the second feature to that of the first
  Lane8x3 gap;      // that vector, m
  Lane8 distance, closing;  // its length, m; of a search: largest relative speed of two points, m/s
};

struct NearKernels {
  // Weights, directions (in `gap`) and distances at `at`, rows of four.
  void (*measure)(PairBatch& b, bool edges, const WideReal* at);
  // The same, closing speeds, and by bits the pairs that may come within `wanted` in `time` (s), when the points move
  // from `at` with `velocity`, but for a deviation in the fourth number of `at`.
  unsigned (*meet)(PairBatch& b, bool edges, const WideReal* at, const WideReal* velocity, WideReal time);
  // The first batch from `first` on with a row whose gap is negative, which `closed` names by bits, or `count`;
  // `displacement`: rows of four.
  unsigned (*next_closed)(const RowBatch* batches, unsigned first, unsigned count, const WideReal* displacement,
                          unsigned& closed);
};

extern const NearKernels kNearKernelsPlain, kNearKernelsAvx2;

}  // namespace feder
