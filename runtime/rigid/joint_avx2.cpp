// Joint kernels compiled with -mavx2 (see CMakeLists.txt); called only where the processor has it.
#include "rigid/joint_kernel.h"

namespace feder {
const JointKernels kJointKernelsAvx2 = {start_joints, warm_start_joints, solve_joints, relax_joints};
}
