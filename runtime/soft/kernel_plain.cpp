// The kernels of tetrahedra without AVX2.
#include "soft/kernel.h"

namespace feder {
const TetKernels kTetKernelsPlain = kTets;
}  // namespace feder
