// The run of candidates compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "neighbors/near_run.h"

namespace feder {
const NearRun kNearRunAvx2 = near_run;
}
