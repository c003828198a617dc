// Joint batches: eight joints side by side that hold two anchors together (three rows along the world axes each), and
// the kernels on them. Plain structs only, since a file compiled with -mavx2 includes them. No two joints of a batch
// push the same solver body.
#pragma once
#include "rigid/contact_batch.h"

namespace feder {

struct PointJointBatch {
  unsigned index_a[kLanes], index_b[kLanes];  // solver indices; 0 = world
  unsigned writes_a, writes_b;                // bit per lane: the solver body can be pushed
  // of the step
  Lane8x3 local_a, local_b;                  // anchors in the centre-of-mass frames, m; 0 on the world's side
  Lane8 arm_a, arm_b;                        // their lengths, m
  Lane8x3 start_gap;                         // between the origins of those frames, at the start of the step, m
  Lane8x3 inv_mass_a, inv_mass_b;            // by world axis, 1/kg
  Lane8 inv_inertia_a[6], inv_inertia_b[6];  // xx yy zz xy xz yz, 1/(kg m^2)
  Lane8 bends_a, bends_b;                    // 1: the bend of the anchor by rotation is predicted, else 0
  // of the substep
  Lane8 share_a, share_b;      // of the inverse inertias (geometric stiffness)
  Lane8x3 moment_a, moment_b;  // arms in the world, m
  Lane8 factor[6];             // of J M^-1 J^T = L D L^T: inverse pivots, then L 10 20 21
  Lane8x3 bend, closing;       // bias with and without correction: relaxed, and what the biased pass adds, m/s
  Lane8x3 impulse;             // on b, N s
};

struct JointPass {
  PointJointBatch* batches;
  unsigned first, last;   // range of batches
  WideReal* bodies;       // SolverBody as 16 numbers each
  const WideReal* share;  // by solver index
  WideReal* strain;       // by solver index: sum of h |impulse| |arm|, kg m^2
  WideReal h;             // s
  WideReal push_speed;    // largest speed at which a gap is closed, m/s
  SoftFactors soft;
};

struct JointKernels {
  void (*start)(const JointPass&);  // rows at the poses now; reads bodies only
  void (*warm_start)(const JointPass&);
  void (*solve)(const JointPass&);  // with bias
  void (*relax)(const JointPass&);  // without bias; sums the strain for the next substep
};

extern const JointKernels kJointKernelsPlain;
extern const JointKernels kJointKernelsAvx2;

}  // namespace feder
