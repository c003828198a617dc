// rasterise: triangles are drawn into the corners a cell around, then the nearest triangle's number is handed on in
// eight sweeps (Bridson 2015, 4.1). exact: then, within three cells of the surface, whether another is nearer is sought
// in the hierarchy. Signs: neighbours that are farther from the surface together
// than from each other lie on one side, so one winding number serves a whole region; rays: parity of crossings along
// three axes, two votes of three. Weak spots: swept distances far from the surface may be those of the second nearest
// triangle, a few per cent too large; parity is wrong where a mesh is open or crosses itself, winding where more than
// half is missing.
#include "geom/sdf_acquire.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr int kBand = 1;             // cells
constexpr Real kSearched = Real(3);  // cells: farther out a few per cent do not matter

}  // namespace

std::vector<float> rasterised(const TriangleField& triangles, const FieldLayout& at) {
  std::vector<float> values(at.corners(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> nearest(at.corners(), kNone);
  const auto offer = [&](std::size_t i, const Vec3& p, std::uint32_t triangle) {
    const auto d = static_cast<float>(std::sqrt(triangles.distance_squared(p, triangle)));
    if (d < values[i]) values[i] = d, nearest[i] = triangle;
  };
  const std::span<const Vec3> corners = triangles.corners();
  for (std::uint32_t t = 0; t < triangles.count(); ++t) {
    Aabb box;
    for (std::size_t k = 0; k < 3; ++k) box.include(corners[3 * std::size_t(t) + k]);
    int lo[3], hi[3];
    at.range(box, kBand * at.spacing, lo, hi);
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y)
        for (int x = lo[0]; x <= hi[0]; ++x) offer(at.index(x, y, z), at.corner(x, y, z), t);
  }
  float way[8];  // to the neighbour, m
  for (int from = 0; from < 8; ++from)
    way[from] = static_cast<float>(at.spacing * std::sqrt(Real((from & 1) + (from >> 1 & 1) + (from >> 2))));
  for (int sweep = 0; sweep < 8; ++sweep) {
    const int step[3] = {sweep & 1 ? -1 : 1, sweep & 2 ? -1 : 1, sweep & 4 ? -1 : 1};
    const auto first = [&](int k) { return step[k] > 0 ? 0 : at.n[k] - 1; };
    for (int z = first(2); z >= 0 && z < at.n[2]; z += step[2])
      for (int y = first(1); y >= 0 && y < at.n[1]; y += step[1])
        for (int x = first(0); x >= 0 && x < at.n[0]; x += step[0]) {
          const std::size_t i = at.index(x, y, z);
          std::uint32_t tried = nearest[i];
          const Vec3 p = at.corner(x, y, z);
          for (int from = 1; from < 8; ++from) {
            const int a = from & 1 ? x - step[0] : x, b = from & 2 ? y - step[1] : y, c = from & 4 ? z - step[2] : z;
            if (a < 0 || b < 0 || c < 0 || a >= at.n[0] || b >= at.n[1] || c >= at.n[2]) continue;
            const std::size_t j = at.index(a, b, c);
            const std::uint32_t t = nearest[j];
            // no nearer here than there by more than the way
            if (t == kNone || t == nearest[i] || t == tried || values[j] - way[from] >= values[i]) continue;
            offer(i, p, tried = t);
          }
        }
  }
  return values;
}

namespace {

// Near the surface; what was swept is a bound that leaves little to search.
void search_nearer(const TriangleField& triangles, const FieldLayout& at, std::vector<float>& values) {
  std::size_t i = 0;
  for (int z = 0; z < at.n[2]; ++z)
    for (int y = 0; y < at.n[1]; ++y)
      for (int x = 0; x < at.n[0]; ++x, ++i) {
        if (Real(values[i]) > kSearched * at.spacing) continue;
        std::uint32_t triangle;
        const Real d = triangles.nearest(at.corner(x, y, z), Real(values[i]), triangle);
        if (triangle != kNone) values[i] = static_cast<float>(std::sqrt(d));
      }
}

// Regions that no triangle parts, each with the sign of one of its corners.
double sign_by_winding(const TriangleField& triangles, const FieldLayout& at, std::vector<float>& values) {
  std::vector<std::uint8_t> seen(values.size(), 0);
  std::vector<std::uint32_t> open;
  double most = 0;
  const auto apart = static_cast<float>(at.spacing * Real(1.001));
  for (std::size_t start = 0; start < values.size(); ++start) {
    if (seen[start]) continue;
    int corner[3];
    at.place_of(start, corner);
    const double turns = triangles.winding(at.corner(corner[0], corner[1], corner[2]));
    most = std::max(most, turns);
    const bool inside = turns > 0.5;
    seen[start] = 1;
    open.assign(1, static_cast<std::uint32_t>(start));
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      const float d = std::abs(values[i]);
      at.place_of(i, corner);
      for (int k = 0; k < 3; ++k)
        for (const int step : {-1, 1}) {
          if (corner[k] + step < 0 || corner[k] + step >= at.n[k]) continue;
          const std::size_t j = step > 0 ? i + at.stride(k) : i - at.stride(k);
          if (seen[j] || !(d + values[j] > apart)) continue;  // not seen: not yet negative
          seen[j] = 1;
          open.push_back(static_cast<std::uint32_t>(j));
        }
      if (inside) values[i] = -values[i];
    }
  }
  return most;
}

// Twice the signed area of a, b, p seen along an axis: exactly opposite for b, a.
double side_of(const double (&a)[2], const double (&b)[2], const double (&p)[2]) {
  const bool turned = a[0] != b[0] ? a[0] > b[0] : a[1] > b[1];
  const double(&from)[2] = turned ? b : a;
  const double(&to)[2] = turned ? a : b;
  const double s = (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0]);
  return turned ? -s : s;
}

// Crossings of the grid's lines along one axis; each corner with an odd number of them before it gets a vote.
void vote_along(const TriangleField& triangles, const FieldLayout& at, int axis, std::vector<std::uint8_t>& votes) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  struct Crossing {
    std::uint64_t line;
    double at;
  };
  std::vector<Crossing> crossings;
  const std::span<const Vec3> corners = triangles.corners();
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    double c[3][2];
    Aabb box;
    for (std::size_t k = 0; k < 3; ++k) {
      c[k][0] = double(corners[t + k][u]), c[k][1] = double(corners[t + k][v]);
      box.include(corners[t + k]);
    }
    int lo[3], hi[3];
    at.range(box, 0, lo, hi);
    for (int j = lo[v]; j <= hi[v]; ++j)
      for (int i = lo[u]; i <= hi[u]; ++i) {
        const double p[2] = {double(at.origin[u] + at.spacing * Real(i)), double(at.origin[v] + at.spacing * Real(j))};
        const double s[3] = {side_of(c[1], c[2], p), side_of(c[2], c[0], p), side_of(c[0], c[1], p)};
        // on an edge: it belongs to one of its two triangles, that on its lower side as the edge runs upwards
        const auto within = [&](double sign) {
          for (std::size_t k = 0; k < 3; ++k) {
            const double(&a)[2] = c[(k + 1) % 3];
            const double(&b)[2] = c[(k + 2) % 3];
            const bool upwards =
                sign > 0 ? (a[0] != b[0] ? a[0] < b[0] : a[1] < b[1]) : (a[0] != b[0] ? a[0] > b[0] : a[1] > b[1]);
            if (!(sign * s[k] > 0 || (s[k] == 0 && upwards))) return false;
          }
          return true;
        };
        if (!within(1) && !within(-1)) continue;
        const double whole = s[0] + s[1] + s[2];
        if (whole == 0) continue;
        double along = 0;
        for (std::size_t k = 0; k < 3; ++k) along += s[k] / whole * double(corners[t + k][axis]);
        crossings.push_back({std::uint64_t(j) * std::uint64_t(at.n[u]) + std::uint64_t(i), along});
      }
  }
  std::sort(crossings.begin(), crossings.end(),
            [](const Crossing& a, const Crossing& b) { return a.line != b.line ? a.line < b.line : a.at < b.at; });
  for (std::size_t first = 0, end = 0; first < crossings.size(); first = end) {
    while (end < crossings.size() && crossings[end].line == crossings[first].line) ++end;
    int place[3];
    place[u] = static_cast<int>(crossings[first].line % std::uint64_t(at.n[u]));
    place[v] = static_cast<int>(crossings[first].line / std::uint64_t(at.n[u]));
    std::size_t passed = first;
    for (int i = 0; i < at.n[axis]; ++i) {
      const double x = double(at.origin[axis] + at.spacing * Real(i));
      while (passed < end && crossings[passed].at < x) ++passed;
      place[axis] = i;
      if ((passed - first) % 2) ++votes[at.index(place[0], place[1], place[2])];
    }
  }
}

void sign_by_rays(const TriangleField& triangles, const FieldLayout& at, std::vector<float>& values) {
  std::vector<std::uint8_t> votes(values.size(), 0);
  for (int axis = 0; axis < 3; ++axis) vote_along(triangles, at, axis, votes);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (votes[i] >= 2) values[i] = -values[i];
}

}  // namespace

Acquired acquire(const TriangleField& triangles, const FieldLayout& layout, SdfAcquire how) {
  Acquired out;
  out.values = rasterised(triangles, layout);
  if (how == SdfAcquire::exact) search_nearer(triangles, layout, out.values);
  if (how == SdfAcquire::rays)
    sign_by_rays(triangles, layout, out.values);
  else
    out.most_turns = sign_by_winding(triangles, layout, out.values);
  return out;
}

}  // namespace feder
