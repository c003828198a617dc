// The kernels of tetrahedra without AVX2.
#include "soft/descent_kernel.h"

namespace feder {
const TetKernels kTetKernelsPlain = kTets;
const SoftPointKernels kSoftPointsPlain[kSoftPointLaws] = {kSoftPoints[0], kSoftPoints[1]};
}  // namespace feder
