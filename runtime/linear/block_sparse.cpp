#include "linear/block_sparse.h"

#include "base/assert.h"

namespace feder {

void BlockSparse::set_pattern(std::size_t count, std::span<const BlockIndex> blocks) {
  index.assign(blocks.begin(), blocks.end());
  for ([[maybe_unused]] const BlockIndex& b : index) FEDER_ASSERT(b.i < b.j && b.j < count);
  off.resize(blocks.size());
  diagonal.resize(count);
  set_zero();
}

void BlockSparse::set_zero() {
  for (Mat3& m : off) m.setZero();
  for (Mat3& m : diagonal) m.setZero();
}

void BlockSparse::multiply(std::span<const Vec3> x, std::span<Vec3> y) const {
  FEDER_ASSERT(x.size() == diagonal.size() && y.size() == diagonal.size());
  for (std::size_t i = 0; i < diagonal.size(); ++i) y[i].noalias() = diagonal[i] * x[i];
  for (std::size_t k = 0; k < off.size(); ++k) {
    const BlockIndex b = index[k];
    const Mat3& m = off[k];
    y[b.i].noalias() += m * x[b.j];
    y[b.j].noalias() += m.transpose() * x[b.i];
  }
}

}  // namespace feder
