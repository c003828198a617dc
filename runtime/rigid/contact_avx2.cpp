// The contact kernels compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "rigid/contact_kernel.h"

namespace feder {
const ContactKernels kContactKernelsAvx2 = kKernels;
}
