// Symmetric sparse matrix of 3x3 blocks: diagonal blocks and the off-diagonal ones (i < j) of a fixed pattern.
// Blocks are double whatever Real is: a stiff spring's float block n n^T k is not semidefinite by k/1e7, and that is
// more than the mass it stands beside.
#pragma once
#include <span>
#include <vector>

#include "feder/error.h"
#include "feder/memory.h"
#include "feder/types.h"

namespace feder {

struct BlockIndex {
  std::uint32_t i, j;  // i < j
};

struct BlockSparse {
  BlockSparse() = default;
  explicit BlockSparse(Arena& a) : index(&a), off(&a), diagonal(&a) {}

  Array<BlockIndex> index;
  Array<Mat3d> off;  // by `index`: block (i, j); block (j, i) is its transpose
  Array<Mat3d> diagonal;

  // Allocates only when the pattern outgrows every earlier one. All blocks become zero.
  void set_pattern(std::size_t count, std::span<const BlockIndex> blocks);
  void set_zero();
  // y = A x; V is Vec3 or Vec3d.
  template <class V>
  void multiply(std::span<const V> x, std::span<Vec3d> y) const {
    FEDER_ASSERT(x.size() == diagonal.size() && y.size() == diagonal.size());
    for (std::size_t i = 0; i < diagonal.size(); ++i) y[i].noalias() = diagonal[i] * x[i].template cast<double>();
    for (std::size_t k = 0; k < off.size(); ++k) {
      const BlockIndex b = index[k];
      y[b.i].noalias() += off[k] * x[b.j].template cast<double>();
      y[b.j].noalias() += off[k].transpose() * x[b.i].template cast<double>();
    }
  }
};

}  // namespace feder
