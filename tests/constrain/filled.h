// The rows that a joint kind writes for one joint.
#pragma once
#include "constrain/joint.h"

namespace feder {

struct Filled {
  Arena arena{"test"};
  Array<Row> rows{&arena};
  Array<RowBlock> blocks{&arena};
  Filled(const JointKind& kind, const JointInput& in) {
    RowWriter out(rows, blocks);
    out.start(in, 7);
    kind.fill(in, out);
  }
};

}  // namespace feder
