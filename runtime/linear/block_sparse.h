// Symmetric sparse matrix of 3x3 blocks: diagonal blocks and the off-diagonal ones (i < j) of a fixed pattern.
#pragma once
#include <span>
#include <vector>

#include "base/arena.h"
#include "base/math.h"

namespace feder {

struct BlockIndex {
  std::uint32_t i, j;  // i < j
};

struct BlockSparse {
  BlockSparse() = default;
  explicit BlockSparse(Arena& a) : index(&a), off(&a), diagonal(&a) {}

  Array<BlockIndex> index;
  Array<Mat3> off;       // by `index`: block (i, j); block (j, i) is its transpose
  Array<Mat3> diagonal;

  // Allocates only when the pattern outgrows every earlier one. All blocks become zero.
  void set_pattern(std::size_t count, std::span<const BlockIndex> blocks);
  void set_zero();
  // y = A x
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;
};

}  // namespace feder
