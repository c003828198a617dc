// An independent count of crossings: every edge against every triangle that shares no vertex with it, by the signs of
// volumes in double precision; flat within rounding counts as not crossing. Only a uniform grid spares far pairs.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "feder/cloth.h"

namespace feder::test {

using Point = std::array<double, 3>;

inline double volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  double m[3][3];
  for (std::size_t k = 0; k < 3; ++k) m[0][k] = b[k] - a[k], m[1][k] = c[k] - a[k], m[2][k] = d[k] - a[k];
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// `flat`: volumes below it are rounding, m^3.
inline bool crosses(const Point& p, const Point& q, const Point& a, const Point& b, const Point& c, double flat) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::max(p[k], q[k]) < std::min({a[k], b[k], c[k]}) || std::min(p[k], q[k]) > std::max({a[k], b[k], c[k]}))
      return false;
  const double above = volume(a, b, c, p), below = volume(a, b, c, q);
  if (!(above > flat && below < -flat) && !(above < -flat && below > flat)) return false;
  const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

// Points and triangles of any number of cloths, numbered through.
struct Soup {
  std::vector<Point> points;
  std::vector<std::uint32_t> triangles;
  void add(const Cloth& cloth, ObjectId id) {
    std::vector<Vec3> x;
    std::vector<std::uint32_t> t;
    cloth.positions(id, x), cloth.triangles(id, t);
    const auto first = static_cast<std::uint32_t>(points.size());
    for (const Vec3& p : x)
      points.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    for (const std::uint32_t v : t) triangles.push_back(first + v);
  }
};

inline std::size_t count_crossings(const Soup& s) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  std::vector<Edge> edges;
  double cell = 0;
  for (std::size_t t = 0; t < s.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = s.triangles[t + k], b = s.triangles[t + (k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b)});
      const Point &p = s.points[a], &q = s.points[b];
      cell = std::max(cell, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  // triangles by the cells their boxes touch; an edge is shorter than a cell, so it asks those of its own box
  std::vector<std::pair<std::int64_t, std::uint32_t>> grid;
  const auto each_cell = [&](std::initializer_list<std::uint32_t> v, auto&& f) {
    int lo[3], hi[3];
    for (std::size_t k = 0; k < 3; ++k) {
      double least = 1e300, most = -1e300;
      for (const std::uint32_t i : v) least = std::min(least, s.points[i][k]), most = std::max(most, s.points[i][k]);
      lo[k] = static_cast<int>(std::floor(least / cell)), hi[k] = static_cast<int>(std::floor(most / cell));
    }
    for (int i = lo[0]; i <= hi[0]; ++i)
      for (int j = lo[1]; j <= hi[1]; ++j)
        for (int k = lo[2]; k <= hi[2]; ++k)
          f((static_cast<std::int64_t>(i) * 73856093) ^ (static_cast<std::int64_t>(j) * 19349663) ^
            (static_cast<std::int64_t>(k) * 83492791));
  };
  for (std::uint32_t t = 0; t < s.triangles.size(); t += 3)
    each_cell({s.triangles[t], s.triangles[t + 1], s.triangles[t + 2]}, [&](std::int64_t key) {
      grid.push_back({key, t});
    });
  std::sort(grid.begin(), grid.end());
  std::size_t found = 0;
  std::vector<std::uint32_t> near;
  for (const auto& [p, q] : edges) {
    near.clear();
    each_cell({p, q}, [&](std::int64_t key) {
      for (auto at = std::lower_bound(grid.begin(), grid.end(), std::pair{key, 0u});
           at != grid.end() && at->first == key; ++at)
        near.push_back(at->second);
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const std::uint32_t t : near) {
      const std::uint32_t* v = &s.triangles[t];
      if (v[0] == p || v[1] == p || v[2] == p || v[0] == q || v[1] == q || v[2] == q) continue;
      found +=
          crosses(s.points[p], s.points[q], s.points[v[0]], s.points[v[1]], s.points[v[2]], 1e-13 * cell * cell * cell);
    }
  }
  return found;
}

}  // namespace feder::test
