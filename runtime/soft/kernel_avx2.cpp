// The kernels of tetrahedra compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "soft/descent_kernel.h"

namespace feder {
const TetKernels kTetKernelsAvx2 = kTets;
const PointKernels kPointsAvx2[kPointLaws] = {kPoints[0], kPoints[1]};
}  // namespace feder
