// Direct solver for symmetric positive definite block matrices: sparse L D L^T of 3x3 blocks.
#pragma once
#include "linear/block_sparse.h"

namespace feder {

// The order of elimination and the slots of all blocks are found once per pattern; after that nothing allocates.
class BlockLdl {
 public:
  explicit BlockLdl(Arena& a)
      : position_(&a), point_(&a), column_(&a), row_(&a), row_start_(&a), row_column_(&a), row_at_(&a), slot_(&a),
        input_at_(&a), block_(&a), factor_(&a), pivot_(&a), work_(&a), work_at_(&a) {}

  // False when the factor would need more than `max_operations` block products: then there is no factor.
  bool analyze(std::size_t count, std::span<const BlockIndex> index, std::uint64_t max_operations);
  std::uint64_t operations() const { return operations_; }  // block products of one factorisation
  // Of a matrix of the analyzed pattern; points with free[i] == 0 are fixed. False when a pivot is not positive: the
  // matrix is indefinite to rounding.
  bool factor(const BlockSparse& a, std::span<const Real> free);
  // A x = b with the last factor; fixed points keep x = 0.
  void solve(std::span<const Vec3> b, std::span<const Real> free, std::span<Vec3> x);

 private:
  bool eliminate(std::size_t count, std::span<const BlockIndex> index, std::uint64_t max_operations);
  void lay_out(std::span<const BlockIndex> index);
  std::uint32_t find(std::uint32_t column, std::uint32_t row) const;

  // numbers below are positions in the order of elimination
  Array<std::uint32_t> position_, point_;  // of a point, and back
  Array<std::uint32_t> column_, row_;      // L by columns: blocks column_[j] .. column_[j+1], ascending rows
  Array<std::uint32_t> row_start_, row_column_, row_at_;  // the same by rows: column and position of each block
  Array<std::uint32_t> slot_;                             // by block of the input: its block in L, transposed if below
  Array<std::uint8_t> input_at_;                          // 1: the input block is (row, column), 0: it is transposed
  Array<Mat3d> block_, factor_, pivot_;                   // L, D factored, D
  Array<Vec3d> work_;
  Array<std::uint32_t> work_at_;  // by position: index of the row in the column at work
  std::uint64_t operations_ = 0;
};

}  // namespace feder
