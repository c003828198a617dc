// The kernels of tetrahedra without AVX2.
#include "soft/descent_kernel.h"

namespace feder {
const TetKernels kTetKernelsPlain = kTets;
const PointKernels kPointsPlain[kPointLaws] = {kPoints[0], kPoints[1]};
}  // namespace feder
