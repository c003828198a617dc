// The cloth kernels without AVX2.
#include "cloth/descent_kernel.h"

namespace feder {
const ClothKernels kClothKernelsPlain = kKernels;
const DescentKernels kDescentPlain = kDescent;
}  // namespace feder
