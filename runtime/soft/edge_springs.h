// Springs along the edges of tetrahedra that make up an elastic material, from the mesh alone. Private to the module.
#pragma once
#include "feder/memory.h"
#include "soft/tetrahedra.h"

namespace feder {

// Of the two ends i < j.
struct SoftSpring {
  std::uint32_t i, j;
  Real rest;    // m
  Real weight;  // stiffness by the shear modulus, m
};

struct SoftCell {
  std::uint32_t v[4], edge[6];  // the springs of its corners, in the order of kCornerPairs
  Vec3 gradient[3];             // of the barycentric weights of v[1], v[2], v[3], 1/m
  Real volume;                  // m^3, at rest
  Real bulk;                    // bulk modulus of the springs there, by the shear modulus
};

// Springs whose elasticity is as near as can be to that of a shear modulus of 1, and how stiff they are against a
// change of volume.
struct SoftSprings {
  explicit SoftSprings(Arena& a) : springs(&a), cells(&a) {}
  void build(const SoftMesh& mesh, std::uint32_t points);

  Array<SoftSpring> springs;  // by i, then by j
  Array<SoftCell> cells;      // as tetrahedra are numbered
};

}  // namespace feder
