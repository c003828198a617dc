// Nets for tests of contact.
#pragma once
#include "feder/net.h"

namespace feder {

// n x n points in the xz plane about `center`, springs along edges and diagonals, two faces per cell.
inline NetDesc grid_net(std::uint32_t n, Real size, const Vec3& center, Real stiffness = 300) {
  NetDesc d;
  const Real step = size / static_cast<Real>(n - 1);
  const auto at = [n](std::uint32_t i, std::uint32_t j) { return j * n + i; };
  const auto spring = [&](std::uint32_t a, std::uint32_t b) {
    SpringDesc s;
    s.i = a, s.j = b, s.stiffness = stiffness, s.damping = Real(0.3);
    d.springs.push_back(s);
  };
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i)
      d.points.push_back(center +
                         Vec3(static_cast<Real>(i) * step - size / 2, 0, static_cast<Real>(j) * step - size / 2));
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i + 1 < n) spring(at(i, j), at(i + 1, j));
      if (j + 1 < n) spring(at(i, j), at(i, j + 1));
      if (i + 1 == n || j + 1 == n) continue;
      spring(at(i, j), at(i + 1, j + 1)), spring(at(i + 1, j), at(i, j + 1));
      for (const std::uint32_t v : {at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)})
        d.faces.push_back(v);
    }
  d.masses.assign(d.points.size(), Real(0.02));
  d.radius = Real(0.03);
  return d;
}

// A tumbling-free jelly ball: the corners of an icosahedron round a middle, all tied to each other.
inline NetDesc jelly_ball(Real radius, const Vec3& center, const Vec3& velocity) {
  NetDesc d;
  const Real a = Real(0.525731), b = Real(0.850651);
  const Real corner[12][3] = {{-a, b, 0},  {a, b, 0},  {-a, -b, 0}, {a, -b, 0}, {0, -a, b},  {0, a, b},
                              {0, -a, -b}, {0, a, -b}, {b, 0, -a},  {b, 0, a},  {-b, 0, -a}, {-b, 0, a}};
  for (const auto& c : corner) d.points.push_back(center + radius * Vec3(c[0], c[1], c[2]));
  d.points.push_back(center);
  d.faces = {0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
             3, 9,  4, 3, 4, 2, 3, 2, 6, 3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};
  for (std::uint32_t i = 0; i < 13; ++i)
    for (std::uint32_t j = i + 1; j < 13; ++j) {
      SpringDesc s;
      s.i = i, s.j = j, s.stiffness = 200, s.damping = Real(0.2);
      d.springs.push_back(s);
    }
  d.masses.assign(13, Real(0.08));
  d.velocities.assign(13, velocity);
  d.radius = Real(0.04);
  return d;
}

}  // namespace feder
