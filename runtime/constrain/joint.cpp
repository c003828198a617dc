// Shared by all joint kinds: the bend of anchors by rotation, and the writer of rows.
#include "constrain/joint.h"

#include "feder/error.h"
#include "state/rows.h"

namespace feder {

Mat3 bend_matrix(const Vec3& start, const Vec3& w, Real h) {
  const Real w2 = dot(w, w), x2 = h * h * w2, inward = h / (2 + x2 / 6);
  const Vec3 along = w - start - x2 / (6 + Real(0.3) * x2) * w, ww = inward * w;
  Mat3 m;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) m(i, k) = ww[i] * w[k];
    m(i, i) -= inward * w2;
  }
  m(0, 1) -= along[2], m(1, 0) += along[2];
  m(0, 2) += along[1], m(2, 0) -= along[1];
  m(1, 2) -= along[0], m(2, 1) += along[0];
  return m;
}

void RowWriter::start(const JointInput& in, std::uint32_t joint) {
  open_ = RowBlock{};
  open_.index_a = in.index_a;
  open_.index_b = in.index_b;
  open_.joint = joint;
  written_ = 0;
}

Row* RowWriter::block(int count) {
  FEDER_ASSERT(count >= 1 && count <= 6 && written_ + count <= kMaxJointRows);
  open_.first = static_cast<std::uint32_t>(rows_.size());
  open_.count = static_cast<std::uint16_t>(count);
  open_.first_impulse = static_cast<std::uint32_t>(written_);
  blocks_.push_back(open_);
  rows_.resize(rows_.size() + static_cast<std::size_t>(count));
  written_ += count;
  return rows_.data() + open_.first;
}

}  // namespace feder
