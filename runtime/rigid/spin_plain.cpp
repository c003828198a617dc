// The kernel of free rotation for any processor.
#include "rigid/spin_kernel.h"

namespace feder {
const SpinKernel kSpinPlain = spin_batches;
}
