// Batches of eight tetrahedra, one per lane, and the kernels that work on them. Plain structs only: included by the
// file that is compiled with -mavx2. No two tetrahedra of a batch, nor of a colour, share a point; empty lanes point to
// a spare point of infinite mass.
#pragma once
#include "base/simd.h"

namespace feder {

struct TetBatch {
  unsigned v[4][kLanes];
  Lane8x3 base[3];      // v[1], v[2], v[3] minus v[0] at the start of the step, m
  Lane8x3 gradient[3];  // of the barycentric weights of v[1], v[2], v[3] at rest, 1/m
  Lane8 volume;         // at rest, m^3; less of flat ones, which count as softer (batches.cpp)
  Lane8 room;           // how often its response fits into that of the body's stiffest tetrahedron, at rest
  Lane8 share;          // of the stress that the last push carried
};

// What stages of damping need of a batch, taken once.
struct TetDamping {
  Lane8x3 f[3];  // columns of the deformation gradient
  Lane8 factor;  // m^3 s^2: volume times damping times time, less where it is strained much
};

struct TetPass {
  TetBatch* tets;
  TetDamping* damping;
  unsigned char* flagged;    // by batch: 1: a lane has a share below 1
  unsigned first, last;      // range of batches
  WideReal* delta_position;  // Row4 as four numbers each
  WideReal* velocity;
  const WideReal* rates;                    // Row4: velocities that `damp` reads, m/s
  WideReal* pushes;                         // Row4: impulses that it adds, N s
  WideReal h;                               // s, that a push stands for
  WideReal mu, lame, shear, lambda, gamma;  // Pa, see SoftMaterial
  WideReal damping_time;                    // damping x time, s^2
  WideReal carried;                         // Pa: stiffness of the stiffest tetrahedron that a push carries
};

struct TetKernels {
  void (*push)(const TetPass&);
  void (*remainder)(const TetPass&);
  void (*damp_begin)(const TetPass&);
  void (*damp)(const TetPass&);
};

extern const TetKernels kTetKernelsPlain, kTetKernelsAvx2;

}  // namespace feder
