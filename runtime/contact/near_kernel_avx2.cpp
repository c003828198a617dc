// The kernels of contact rows compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "contact/near_kernel.h"

namespace feder {
const NearKernels kNearKernelsAvx2 = kNearKernels;
}  // namespace feder
