// The cloth kernels without AVX2.
#include "cloth/kernel.h"

namespace feder {
const ClothKernels kClothKernelsPlain = kKernels;
}
