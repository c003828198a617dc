// Pattern and zero of a block matrix.
#include "linear/block_sparse.h"

#include "feder/error.h"

namespace feder {

void BlockSparse::set_pattern(std::size_t count, std::span<const BlockIndex> blocks) {
  index.assign(blocks.begin(), blocks.end());
  for ([[maybe_unused]] const BlockIndex& b : index) FEDER_ASSERT(b.i < b.j && b.j < count);
  off.resize(blocks.size());
  diagonal.resize(count);
  set_zero();
}

void BlockSparse::set_zero() {
  for (Mat3d& m : off) m.setZero();
  for (Mat3d& m : diagonal) m.setZero();
}

}  // namespace feder
