// The kernels of contact rows for any processor.
#include "contact/near_kernel.h"

namespace feder {
const NearKernels kNearKernelsPlain = kNearKernels;
}  // namespace feder
