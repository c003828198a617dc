// Symmetric sparse matrix of 3x3 blocks: diagonal blocks and the off-diagonal ones (i < j) of a fixed pattern.
#pragma once
#include <span>
#include <vector>

#include "base/math.h"

namespace feder {

struct BlockIndex {
  std::uint32_t i, j;  // i < j
};

struct BlockSparse {
  std::vector<BlockIndex> index;
  std::vector<Mat3> off;       // by `index`: block (i, j); block (j, i) is its transpose
  std::vector<Mat3> diagonal;

  void set_pattern(std::size_t count, std::span<const BlockIndex> blocks);
  void set_zero();
  // y = A x
  void multiply(std::span<const Vec3> x, std::span<Vec3> y) const;
};

}  // namespace feder
