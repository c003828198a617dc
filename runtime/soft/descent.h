// The arithmetic of vertex block descent, eight points of a colour at a time. Plain structs and kernels, included by
// kernel_plain.cpp and kernel_avx2.cpp, which differ in compiler flags only and give the same bits. See vbd.cpp.
#pragma once
#include "base/simd.h"

namespace feder {

// One tetrahedron of each of eight points, its other corners in the order of the mesh. Lanes without one name the point
// itself and have no volume.
struct SoftPointTet {
  unsigned other[3][kLanes];
  Lane8x3 base[3];      // the others minus this at the start of the step, m
  Lane8x3 gradient[3];  // of the barycentric weights of the others at rest, 1/m
  Lane8 volume;         // m^3, at rest
};

struct SoftPointBatch {
  unsigned self[kLanes];
  unsigned first, last;  // its tetrahedra
  Lane8 mass;            // kg; 0: fixed, or an empty lane
  Lane8x3 goal;          // where inertia and forces from outside lead, displacement since the step began, m
};

struct SoftPointPass {
  const SoftPointBatch* batches;
  const SoftPointTet* tets;
  unsigned first, last;      // range of batches
  WideReal* delta_position;  // Row4 as four numbers each
  const WideReal* before;    // likewise, at the start of the solver substep
  WideReal* force;           // Row4: of tetrahedra at that start, N
  WideReal inv_h2;           // 1/h^2 of the solver substep
  WideReal relaxation;
  WideReal mu, lame, shear, lambda, gamma;  // Pa, see SoftMaterial
};

struct SoftPointKernels {
  const char* law;
  void (*begin)(const SoftPointPass&);    // forces
  void (*descend)(const SoftPointPass&);  // a sweep
};

inline constexpr int kSoftPointLaws = 2;
extern const SoftPointKernels kSoftPointsPlain[kSoftPointLaws], kSoftPointsAvx2[kSoftPointLaws];

}  // namespace feder
