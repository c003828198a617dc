// The kernel of free rotation compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "rigid/spin_kernel.h"

namespace feder {
const SpinKernel kSpinAvx2 = spin_batches;
}
