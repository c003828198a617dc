// An independent count of crossings: every edge against every triangle that shares no vertex with it, by the signs of
// volumes in double precision. Only a uniform grid over the edges' boxes spares pairs that are far apart.
#pragma once
#include <algorithm>
#include <map>
#include <vector>

#include "cloth/cloth.h"

namespace feder::test {

struct Crossing {
  std::uint32_t edge[2], triangle;
};

inline double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double m[3][3];
  for (int k = 0; k < 3; ++k) {
    m[0][k] = static_cast<double>(b[k]) - static_cast<double>(a[k]);
    m[1][k] = static_cast<double>(c[k]) - static_cast<double>(a[k]);
    m[2][k] = static_cast<double>(d[k]) - static_cast<double>(a[k]);
  }
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

inline bool crosses(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const double above = volume(a, b, c, p), below = volume(a, b, c, q);
  if (above * below >= 0) return false;
  const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

// Points and triangles of any number of cloths, numbered through.
struct Soup {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> triangles;
  void add(const Cloth& cloth, ObjectId id) {
    std::vector<Vec3> x;
    std::vector<std::uint32_t> t;
    cloth.positions(id, x), cloth.triangles(id, t);
    const auto first = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), x.begin(), x.end());
    for (const std::uint32_t v : t) triangles.push_back(first + v);
  }
};

inline std::size_t count_crossings(const Soup& s) {
  const std::size_t count = s.triangles.size() / 3;
  double cell = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t t = 0; t < count; ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = s.triangles[3 * t + static_cast<std::size_t>(k)], b = s.triangles[3 * t + static_cast<std::size_t>((k + 1) % 3)];
      edges[{std::min(a, b), std::max(a, b)}] = 1;
      cell = std::max(cell, static_cast<double>(length(s.points[a] - s.points[b])));
    }
  const auto key = [&](int i, int j, int k) { return (static_cast<std::int64_t>(i) * 73856093) ^ (static_cast<std::int64_t>(j) * 19349663) ^ (static_cast<std::int64_t>(k) * 83492791); };
  const auto slot = [&](Real x) { return static_cast<int>(std::floor(static_cast<double>(x) / cell)); };
  std::map<std::int64_t, std::vector<std::uint32_t>> grid;
  for (std::uint32_t t = 0; t < count; ++t) {
    Vec3 lo = s.points[s.triangles[3 * t]], hi = lo;
    for (std::uint32_t k = 1; k < 3; ++k) lo = lo.cwiseMin(s.points[s.triangles[3 * t + k]]), hi = hi.cwiseMax(s.points[s.triangles[3 * t + k]]);
    for (int i = slot(lo[0]); i <= slot(hi[0]); ++i)
      for (int j = slot(lo[1]); j <= slot(hi[1]); ++j)
        for (int k = slot(lo[2]); k <= slot(hi[2]); ++k) grid[key(i, j, k)].push_back(t);
  }
  std::size_t found = 0;
  for (const auto& [e, one] : edges) {
    const Vec3 &p = s.points[e.first], &q = s.points[e.second];
    const Vec3 lo = p.cwiseMin(q), hi = p.cwiseMax(q);
    std::vector<std::uint32_t> near;
    for (int i = slot(lo[0]); i <= slot(hi[0]); ++i)
      for (int j = slot(lo[1]); j <= slot(hi[1]); ++j)
        for (int k = slot(lo[2]); k <= slot(hi[2]); ++k)
          if (const auto at = grid.find(key(i, j, k)); at != grid.end()) near.insert(near.end(), at->second.begin(), at->second.end());
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const std::uint32_t t : near) {
      const std::uint32_t* v = &s.triangles[3 * t];
      if (v[0] == e.first || v[1] == e.first || v[2] == e.first || v[0] == e.second || v[1] == e.second || v[2] == e.second) continue;
      found += crosses(p, q, s.points[v[0]], s.points[v[1]], s.points[v[2]]);
    }
  }
  return found;
}

}  // namespace feder::test
