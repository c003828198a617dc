// The spring kernels for any processor.
#include "springs/spring_kernel.h"

namespace feder {
const SpringKernels kSpringKernelsPlain = kKernels;
}
