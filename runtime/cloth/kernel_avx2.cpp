// The cloth kernels compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "cloth/descent_kernel.h"

namespace feder {
const ClothKernels kClothKernelsAvx2 = kKernels;
const DescentKernels kDescentAvx2 = kDescent;
}  // namespace feder
