// The kernels of free motion compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "rigid/spin_kernel.h"

namespace feder {
const SpinKernels kSpinKernelsAvx2 = {spin_batches, push_bodies, drift_bodies};
}
