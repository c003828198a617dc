// The kernels of flat parts compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "contact/flat_kernel.h"

namespace feder {
const FlatKernels kFlatKernelsAvx2 = kFlatKernels;
}  // namespace feder
