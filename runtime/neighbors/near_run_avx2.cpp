// The choice among candidates compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "neighbors/near_run.h"

namespace feder {
const NearKernels kNearAvx2 = {collect, choose_near};
}
