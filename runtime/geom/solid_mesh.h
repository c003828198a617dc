// Tetrahedra that fill a solid: boxes by a lattice that fits them, every other shape by isosurface stuffing.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "feder/shape.h"

namespace feder {

struct SolidMesh {
  std::vector<Vec3> points;                                // m, in the shape's frame
  std::vector<std::array<std::uint32_t, 4>> tetrahedra{};  // of volume above 0
};

inline constexpr double kMaxSolidCells = 1e7;

// `resolution`: cells along the longest side of the shape's box. SceneError for shapes without a finite volume and for
// more than kMaxSolidCells cells, which is checked first. Checked by tests/geom/test_solid_mesh.cpp: the tetrahedra
// meet face to face, fill the shape's volume, and have no small angles.
SolidMesh fill_shape(const Shape& shape, std::uint32_t resolution);

}  // namespace feder
