// The kernels of free motion for any processor.
#include "rigid/spin_kernel.h"

namespace feder {
const SpinKernels kSpinKernelsPlain = {spin_batches, push_bodies, drift_bodies};
}
