#include "constrain/joint.h"

#include "base/assert.h"

namespace feder {

void RowWriter::start(const JointInput& in, std::uint32_t joint) {
  open_ = RowBlock{};
  open_.mover_a = in.mover_a;
  open_.mover_b = in.mover_b;
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
