// The run of candidates for any processor.
#include "neighbors/near_run.h"

namespace feder {
const NearRun kNearRunPlain = near_run;
}
