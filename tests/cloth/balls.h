// Closed meshes for tests: an octahedron, divided and drawn onto a sphere.
#pragma once
#include <array>
#include <cmath>
#include <map>

#include "cloth/sheets.h"

namespace feder::test {

inline void ball(int level, double radius, std::vector<Vec3>& vertices, std::vector<std::uint32_t>& triangles) {
  using Point = std::array<double, 3>;
  std::vector<Point> x = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  triangles = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  for (int n = 0; n < level; ++n) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto half = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(x.size()));
      if (fresh) {
        Point p{};
        double size = 0;
        for (std::size_t k = 0; k < 3; ++k) p[k] = x[a][k] + x[b][k], size += p[k] * p[k];
        for (double& c : p) c /= std::sqrt(size);
        x.push_back(p);
      }
      return at->second;
    };
    std::vector<std::uint32_t> finer;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const std::uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
      const std::uint32_t ab = half(a, b), bc = half(b, c), ca = half(c, a);
      finer.insert(finer.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    triangles = finer;
  }
  vertices.clear();
  for (const Point& p : x) vertices.push_back(Vec3(Real(radius * p[0]), Real(radius * p[1]), Real(radius * p[2])));
}

inline ClothDesc balloon(int level, double radius) {
  ClothDesc d;
  ball(level, radius, d.vertices, d.triangles);
  d.self_collision = false;
  d.wind = false;
  return d;
}

}  // namespace feder::test
