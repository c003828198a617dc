// The arithmetic of vertex block descent, eight vertices of a colour at a time. Plain structs and kernels, included by
// kernel_plain.cpp and kernel_avx2.cpp, which differ in compiler flags only and give the same bits. See vbd.cpp.
#pragma once
#include "base/simd.h"

namespace feder {

// One link of each of eight vertices. Lanes without one name the vertex itself and have no stiffness.
struct DescentLink {
  unsigned other[kLanes];
  Lane8x3 base;           // the other minus this at the start of the step, m
  Lane8 rest, stiffness;  // m; N/m
  Lane8 longest;          // where the strain limit begins in this solver substep, m
};

// One hinge of each of eight vertices, linearised. Lanes without one have a number of their own, and no gradient.
struct DescentHinge {
  unsigned hinge[kLanes];
  Lane8x3 gradient;  // of the angle times the root of the stiffness, N^(1/2)
};

struct DescentBatch {
  unsigned self[kLanes];
  unsigned first_link, last_link, first_hinge, last_hinge;
  Lane8 mass;    // kg
  Lane8x3 goal;  // where inertia and forces that are not in the potential lead, displacement since the step began, m
};

// Eight hinges, to be linearised.
struct DescentBend {
  unsigned v[4][kLanes];
  unsigned slot[4][kLanes];         // where their gradients go: entry and lane
  Lane8x3 base[3];                  // v[1], v[2], v[3] minus v[0] at the start of the step, m
  Lane8 cosine, sine;               // of the rest angle
  Lane8 root;                       // of the stiffness, (N m)^(1/2)
  Lane8 edge_floor, area_floor[2];  // HingeFloor
};

struct DescentPass {
  DescentBatch* batches;
  DescentLink* links;
  DescentHinge* hinges;
  const DescentBend* bends;
  unsigned first, last;      // range of batches, or of bends
  WideReal* delta_position;  // Row4 as four numbers each
  const WideReal* before;    // likewise, at the start of the solver substep
  WideReal* force;           // Row4: of links and hinges at that start, N
  WideReal* angle;           // of hinges, from rest, times the root of the stiffness
  WideReal inv_h2;           // 1/h^2 of the solver substep
  WideReal relaxation;
  WideReal stretched, limit;  // length over rest where the strain limit begins; stiffness beyond it, times that below
  WideReal shed;              // excess length that is taken back at most, m
  bool hinged;                // hinges take part
};

struct DescentKernels {
  void (*begin)(const DescentPass&);    // forces, and strain limits of links
  void (*bend)(const DescentPass&);     // angles and gradients of hinges
  void (*descend)(const DescentPass&);  // a sweep
};

extern const DescentKernels kDescentPlain, kDescentAvx2;

}  // namespace feder
