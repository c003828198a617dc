// The cloth kernels compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "cloth/kernel.h"

namespace feder {
const ClothKernels kClothKernelsAvx2 = kKernels;
}
