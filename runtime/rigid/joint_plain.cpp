// Joint kernels for any processor.
#include "rigid/joint_kernel.h"

namespace feder {
const JointKernels kJointKernelsPlain = {start_joints, warm_start_joints, solve_joints, relax_joints};
}
