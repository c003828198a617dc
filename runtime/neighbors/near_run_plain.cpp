// The choice among candidates for any processor.
#include "neighbors/near_run.h"

namespace feder {
const NearKernels kNearPlain = {collect, choose_near};
}
