// The spring kernels compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "springs/spring_kernel.h"

namespace feder {
const SpringKernels kSpringKernelsAvx2 = kKernels;
}
