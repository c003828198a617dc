// The contact kernels for any processor.
#include "rigid/contact_kernel.h"

namespace feder {
const ContactKernels kContactKernelsPlain = kKernels;
}
