// The kernels of flat parts for any processor.
#include "contact/flat_kernel.h"

namespace feder {
const FlatKernels kFlatKernelsPlain = kFlatKernels;
}  // namespace feder
