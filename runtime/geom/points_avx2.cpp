// The kernels of points compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "geom/points_kernel.h"

namespace feder {
const PointKernel kPointsAvx2 = {farthest_point, rotated_bounds};
}
