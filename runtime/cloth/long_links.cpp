#include "cloth/long_links.h"

#include <algorithm>

namespace feder {
namespace {
constexpr int kMostEdges = 8, kLeastEdges = 4;  // of a long link
constexpr Real kStraight = Real(0.9);           // cosine of the largest turn from one edge to the next
constexpr int kBorderRings = 3;
constexpr std::uint32_t kFewPoints = 400;
}  // namespace

std::vector<LongLink> long_links(const ClothMesh& mesh, const Vec3* rest, std::uint32_t points) {
  std::vector<LongLink> all;
  if (points < kFewPoints) return all;
  const Incidence around(points, [&](auto&& f) {
    for (std::uint32_t k = 0; k < mesh.links.size(); ++k)
      if (const ClothLink& l = mesh.links[k]; !l.shear) f(l.a, k), f(l.b, k);
  });
  const auto other = [&](std::uint32_t link, std::uint32_t i) {
    const ClothLink& l = mesh.links[link];
    return l.a == i ? l.b : l.a;
  };
  // From points of which no two share a link, each way once: those between are held by their links. Near borders, where
  // sheets that hang at corners are tight, from all.
  std::vector<bool> beside(points, false), border(points, false);
  for (int ring = 0; ring < kBorderRings; ++ring) {
    const std::vector<bool> inner = border;
    for (const ClothEdge& e : mesh.edges)
      if (e.triangle[1] == kNone || inner[e.a] || inner[e.b]) border[e.a] = border[e.b] = true;
  }
  for (std::uint32_t first = 0; first < points; ++first) {
    if (beside[first] && !border[first]) continue;
    for (const std::uint32_t k : around.of(first)) beside[other(k, first)] = true;
    for (const std::uint32_t start : around.of(first)) {
      std::uint32_t at = other(start, first);
      Vec3 way = rest[at] - rest[first];
      Real along = length(way);
      way = normalized_or(way, Vec3(0, 0, 0));
      int edges = 1;
      while (edges < kMostEdges) {
        std::uint32_t next = kNone;
        Real best = kStraight;
        for (const std::uint32_t k : around.of(at)) {
          const std::uint32_t j = other(k, at);
          const Vec3 d = normalized_or(Vec3(rest[j] - rest[at]), Vec3(0, 0, 0));
          if (const Real turn = dot(d, way); turn > best) best = turn, next = j;
        }
        if (next == kNone) break;
        const Vec3 d = rest[next] - rest[at];
        along += length(d), way = normalized_or(d, way), at = next, ++edges;
      }
      if (edges >= kLeastEdges && at > first) all.push_back({first, at, along});
    }
  }
  std::sort(all.begin(), all.end(), [](const LongLink& x, const LongLink& y) {
    return x.a != y.a ? x.a < y.a : x.b != y.b ? x.b < y.b : x.rest < y.rest;
  });
  all.erase(std::unique(all.begin(), all.end(),
                        [](const LongLink& x, const LongLink& y) { return x.a == y.a && x.b == y.b; }),
            all.end());
  return all;
}

}  // namespace feder
