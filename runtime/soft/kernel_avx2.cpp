// The kernels of tetrahedra compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "soft/descent_kernel.h"

namespace feder {
const TetKernels kTetKernelsAvx2 = kTets;
const SoftPointKernels kSoftPointsAvx2[kSoftPointLaws] = {kSoftPoints[0], kSoftPoints[1]};
}  // namespace feder
