// The kernels of points for any processor.
#include "geom/points_kernel.h"

namespace feder {
const PointKernel kPointsPlain = {farthest_point, rotated_bounds};
}
