// The table of joint kinds, generated from the feder_variant(constrain ...) lines. The kinds live in their own
// namespace because the generated text says `Row`, which is a constraint row outside of it.
#include "constrain/joint.h"

namespace feder {
namespace joints {

using Row = JointKind;
#include "constrain_declare.inc"

}  // namespace joints

std::span<const JointKind> joint_kinds() {
  using namespace joints;
  static const std::initializer_list<JointKind> table = {
#include "constrain_rows.inc"
  };
  return {table.begin(), table.size()};
}

}  // namespace feder
