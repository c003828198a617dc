// The kernels of tetrahedra compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "soft/kernel.h"

namespace feder {
const TetKernels kTetKernelsAvx2 = kTets;
}  // namespace feder
