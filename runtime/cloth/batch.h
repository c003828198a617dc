// Batches of eight links or hinges, one per lane, and the kernels that work on them. Plain structs only: included by
// the file that is compiled with -mavx2. No two elements of a batch, nor of a colour, share a vertex; empty lanes point
// to a spare vertex of infinite mass.
#pragma once
#include "base/simd.h"

namespace feder {

struct LinkBatch {
  unsigned a[kLanes], b[kLanes];
  Lane8x3 base;      // b minus a at the start of the step, m
  Lane8 rest;        // m
  Lane8 compliance;  // m/N
  Lane8 multiplier;  // of this solver substep, N s^2
};

struct HingeBatch {
  unsigned v[4][kLanes];
  Lane8x3 base[3];     // v[1], v[2], v[3] minus v[0] at the start of the step, m
  Lane8 cosine, sine;  // of the rest angle
  Lane8 compliance;    // rad/(N m)
  Lane8 multiplier;    // N m s^2
};

// Largest speeds at which excess length from before a solver substep is taken back, m/s: of ties to bodies, which take
// the opposite impulse, and of links and ties to pins.
inline constexpr WideReal kTieSpeed = 3, kShedSpeed = 20;

// Ties of eight vertices to fixed anchors: their distance stays below that along the cloth. No vertex twice in a layer.
struct TieBatch {
  unsigned a[kLanes];
  Lane8x3 base;  // a minus its anchor at the start of the step, m
  Lane8 limit;   // m
};

// Damping rows of hinges, linearised at the start of a damping pass.
struct HingeDamping {
  Lane8x3 gradient[4];  // of the angle, rad/m
  Lane8 factor;         // impulse per rate, N m s per rad/s
  Lane8 max_response;   // of sum w |gradient|^2 k: the value at rest, 1/s^2
};

// Eight rows of the matrix of quadratic bending (bending.h), and their numbers: entries first .. last - 1.
struct BendBlock {
  unsigned vertex[kLanes];
  unsigned first, last;
  Lane8x3 force;  // at the start of the step, N
};

struct BendEntry {
  unsigned other[kLanes];
  Lane8 stiffness;  // N/m
};

// Eight triangles in still air.
struct AirBatch {
  unsigned v[3][kLanes];
};

struct AirPass {
  const AirBatch* batches;
  unsigned first, last;                           // range of batches
  const WideReal *position, *velocity, *weights;  // Row4: m, m/s, and inverse masses as their fourth numbers
  WideReal* push;                                 // Row4 by triangle: a third of its force, N
  WideReal density, most, drag, lift, skin;       // as in still_air.h and forces/area.h
  WideReal least, largest;                        // of normal numbers
  WideReal taken;                                 // out: largest of what was asked for over what may be stopped
};

struct ClothPass {
  LinkBatch* links;
  HingeBatch* hinges;
  HingeDamping* damping;
  TieBatch* ties;
  const BendBlock* bend_blocks;
  const BendEntry* bend_entries;
  unsigned first, last;      // range of batches
  WideReal* delta_position;  // Row4 as four numbers each
  const WideReal* before;    // likewise, at the start of the solver substep
  WideReal* velocity;
  WideReal inv_h2;        // 1/h^2 of the solver substep
  WideReal h;             // s, of the solver substep
  WideReal damping_time;  // damping x h of the substep, s^2
  WideReal* rates;        // Row4: velocities that `damp_stage` reads, m/s
  WideReal* pushes;       // Row4: impulses that it adds, N s
  WideReal stretched;     // 1 + the largest strain of a link
  bool again;             // a further sweep of this solver substep: multipliers go on; else they begin at zero
  bool once;              // it is the only one
};

struct ClothKernels {
  void (*links)(const ClothPass&);
  void (*limited_links)(const ClothPass&);  // that stretch to p.stretched at most
  void (*taut_links)(const ClothPass&);     // of a cloth that tension holds, in its first sweep
  void (*limited_taut_links)(const ClothPass&);
  void (*limit_links)(const ClothPass&);  // the same without their force
  void (*ties)(const ClothPass&);
  void (*hinges)(const ClothPass&);
  void (*bend_hinges)(const ClothPass&);
  void (*bend_flat)(const ClothPass&);
  void (*damp_links)(const ClothPass&);
  void (*damp_hinges)(const ClothPass&);
  void (*damp_begin)(const ClothPass&);
  void (*damp_stage)(const ClothPass&);
  void (*still_air)(AirPass&);
};

extern const ClothKernels kClothKernelsPlain, kClothKernelsAvx2;

}  // namespace feder
