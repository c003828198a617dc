// Free motion of eight bodies side by side: rotation by uneven moments of inertia, and what velocities do to poses.
// Plain structs only, since a file compiled with -mavx2 includes them.
#pragma once
#include "base/simd.h"

namespace feder {

struct SpinBatch {
  unsigned index[kLanes];  // solver indices
  unsigned count;          // lanes in use; the others have the index of the first
  Lane8x3 axis;            // principal axes of inertia in the body frame: vector part of a unit quaternion, and
  Lane8 real;              // its real part
  Lane8x3 inv_moments;     // about them, 1/(kg m^2)
  Lane8x3 saddle;          // inv_moments minus the middle one of them, 1/(kg m^2)
  Lane8 invariant;         // 2 E - |L|^2 / (middle moment), J: sum of saddle L^2; kUnknownSpin when pushed meanwhile
  Lane8 inertia[6];        // at the start of the step, world axes, xx yy zz xy xz yz, kg m^2
  Lane8x3 momentum;        // angular, world, N m s
  Lane8x3 torque;          // world, N m
  Lane8 damping;           // 1/s
  Lane8x3 given;           // angular velocity of that momentum, rad/s
};
inline constexpr WideReal kUnknownSpin = 3e38f;

struct SpinPass {
  SpinBatch* batches;
  unsigned first, last;  // range of batches
  WideReal* bodies;      // SolverBody as 16 numbers each
  bool start;            // first substep of the step
  WideReal h;            // s
  WideReal close;        // a change of the angle by less ends the rounds, rad
};

// What a substep does to the velocities of a body, in the order of the first row of a SolverBody.
struct BodyPush {
  Lane8 change;  // accelerations, m/s^2 and rad/s^2, and two zeros
  Lane8 keep;    // factors by damping, 0 on locked axes, and two ones
};

struct PushPass {
  WideReal* bodies;        // SolverBody as 16 numbers each
  const BodyPush* pushes;  // by solver index
  unsigned first, last;    // range of solver indices
  WideReal h;              // s
};

struct DriftPass {
  WideReal* bodies;      // SolverBody as 16 numbers each
  unsigned first, last;  // range of solver indices
  WideReal h;            // s
};

struct SpinKernels {
  void (*spin)(const SpinPass&);
  bool (*push)(const PushPass&);    // false: something is not finite
  void (*drift)(const DriftPass&);  // displacements and poses, by the velocities
};
extern const SpinKernels kSpinKernelsPlain;
extern const SpinKernels kSpinKernelsAvx2;
const SpinKernels& spin_kernels(bool wide);

}  // namespace feder
