// Tetrahedra as pure functions, in double: corners a, b, c, d, of which b, c, d turn counter-clockwise seen from a
// point on the far side of them from a (volume above 0).
#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "base/double3.h"

namespace feder {

using Corners = std::array<Double3, 4>;

// m^3; below 0 for one that is turned inside out.
inline double tetrahedron_volume(const Corners& x) { return dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) / 6; }

// Longest edge, m.
inline double longest_edge(const Corners& x) {
  double square = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) square = std::fmax(square, dot(x[i] - x[j], x[i] - x[j]));
  return std::sqrt(square);
}

// Gradients of the four barycentric weights, 1/m: weight i is 1 at corner i, 0 on the face across. The volume is not 0.
inline Corners barycentric_gradients(const Corners& x) {
  const Double3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const double inv = 1 / dot(a, cross(b, c));
  const Double3 g1 = inv * cross(b, c), g2 = inv * cross(c, a), g3 = inv * cross(a, b);
  return {-(g1 + g2 + g3), g1, g2, g3};
}

// Barycentric weights of p; all of them lie in [0, 1] where p is within.
inline std::array<double, 4> barycentric(const Corners& x, const Double3& p) {
  const Corners g = barycentric_gradients(x);
  const Double3 r = p - x[0];
  const double w1 = dot(g[1], r), w2 = dot(g[2], r), w3 = dot(g[3], r);
  return {1 - w1 - w2 - w3, w1, w2, w3};
}

// Corner numbers of the four faces, the i-th across corner i, counter-clockwise seen from outside.
inline constexpr int kTetrahedronFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// Whether p lies within, faces included: by its weights, and by its side of the four planes. The two agree but for what
// lies within 1e-7 of the longest edge of a plane (tests/geom/test_tetrahedron.cpp). Nothing lies within a tetrahedron
// without volume; one that is turned inside out holds what it held.
inline bool within_by_weights(const Corners& x, const Double3& p) {
  for (const double w : barycentric(x, p))
    if (!(w >= 0 && w <= 1)) return false;
  return true;
}
inline bool within_by_faces(const Corners& x, const Double3& p) {
  const double volume = tetrahedron_volume(x);
  if (!(volume != 0)) return false;
  for (const auto& f : kTetrahedronFaces) {
    const Double3 &a = x[std::size_t(f[0])], &b = x[std::size_t(f[1])], &c = x[std::size_t(f[2])];
    const double out = dot(cross(b - a, c - a), p - a);
    if (!(volume > 0 ? out <= 0 : out >= 0)) return false;
  }
  return true;
}

// Smallest angle between two faces, rad.
double smallest_dihedral(const Corners& x);

}  // namespace feder
