// Edges by pairing the sides of faces that run between the same two corners; planes by Newell's normal in double, at
// the mean height of a face's corners. A hull of merged triangles may be bent a little: that is measured.
#include "geom/hull_features.h"

#include <algorithm>
#include <map>

#include "geom/hull.h"

namespace feder {

FeatureGraph::FeatureGraph(std::vector<Double3> vertices, std::span<const HullFace> faces,
                           std::span<const std::uint16_t> loops)
    : vertices_(std::move(vertices)) {
  if (!close(faces, loops)) return;
  set_planes();
  view_ = {vertices_, edges_, faces_, loops_, spokes_, first_spoke_};
  measure();
}

// False where an edge has not two faces, or a vertex not three edges.
bool FeatureGraph::close(std::span<const HullFace> faces, std::span<const std::uint16_t> loops) {
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint16_t> known;
  std::vector<int> sides;
  for (const HullFace& f : faces) {
    const auto number = static_cast<std::uint16_t>(faces_.size());
    faces_.push_back({{}, 0, static_cast<std::uint16_t>(loops_.size()), f.count});
    for (std::size_t i = 0; i < f.count; ++i) {
      const std::uint16_t p = loops[f.first + i], q = loops[f.first + (i + 1) % f.count];
      if (p == q) return false;
      const auto [it, made] = known.try_emplace(std::minmax(p, q), static_cast<std::uint16_t>(edges_.size()));
      const std::uint16_t e = it->second;
      if (made) {
        const Double3 d = vertices_[q] - vertices_[p];
        const double len = length(d);
        if (!(len > 0)) return false;
        edges_.push_back({p, q, number, number, (1 / len) * d});
        sides.push_back(1);
      } else if (edges_[e].tail != q || edges_[e].head != p || ++sides[e] > 2) {
        return false;
      } else {
        edges_[e].right = number;
      }
      loops_.push_back(static_cast<EdgeUse>(e << 1 | (made ? 0 : 1)));
    }
  }
  if (std::any_of(sides.begin(), sides.end(), [](int n) { return n != 2; })) return false;
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    first_spoke_.push_back(static_cast<std::uint16_t>(spokes_.size()));
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (edges_[e].tail == v) spokes_.push_back(static_cast<EdgeUse>(e << 1));
      if (edges_[e].head == v) spokes_.push_back(static_cast<EdgeUse>(e << 1 | 1));
    }
    if (spokes_.size() - first_spoke_.back() < 3) return false;
  }
  first_spoke_.push_back(static_cast<std::uint16_t>(spokes_.size()));
  return vertices_.size() + faces_.size() == edges_.size() + 2;
}

void FeatureGraph::set_planes() {
  for (FeatureFace& f : faces_) {
    const auto corner = [&](std::size_t i) {
      const EdgeUse use = loops_[f.first + i];
      return vertices_[use & 1 ? edges_[use >> 1].head : edges_[use >> 1].tail];
    };
    Double3 n{0, 0, 0};
    for (std::size_t i = 2; i < f.count; ++i) n = n + cross(corner(i - 1) - corner(0), corner(i) - corner(0));
    const double len = length(n);
    f.normal = (len > 0 ? 1 / len : 0) * n;
    double sum = 0;
    for (std::size_t i = 0; i < f.count; ++i) sum += dot(f.normal, corner(i));
    f.offset = sum / f.count;
  }
}

void FeatureGraph::measure() {
  for (const Double3& p : vertices_) view_.reach = std::max({view_.reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  Double3 low = vertices_[0], high = low;
  for (const Double3& p : vertices_) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  view_.size = length(high - low);
  const double limit = kBent * view_.size;
  const auto above = [&](const FeatureFace& plane, const FeatureFace& other) {
    double most = -limit;
    for (const EdgeUse use : view_.loop(other))
      most = std::max(most, dot(plane.normal, vertices_[view_.far_end(use)]) - plane.offset);
    return most;
  };
  for (const FeatureFace& f : faces_) {
    for (const EdgeUse use : view_.loop(f))
      view_.bent |= !(std::abs(dot(f.normal, vertices_[view_.far_end(use)]) - f.offset) <= limit);
    view_.bent |= !(length(f.normal) > 0.5);
  }
  for (const FeatureEdge& e : edges_)
    view_.bent |= above(faces_[e.left], faces_[e.right]) > limit || above(faces_[e.right], faces_[e.left]) > limit;
}

std::size_t FeatureGraph::bytes() const {
  return vertices_.size() * sizeof(Double3) + edges_.size() * sizeof(FeatureEdge) +
         faces_.size() * sizeof(FeatureFace) +
         (loops_.size() + spokes_.size() + first_spoke_.size()) * sizeof(std::uint16_t);
}

const FeatureGraph& Hull::features() const {
  std::call_once(features_made_, [this] {
    std::vector<Double3> vertices;
    for (const Vec3& c : data_.corners) vertices.push_back(wide(c));
    features_ = std::make_shared<const FeatureGraph>(std::move(vertices), data_.faces, data_.loops);
  });
  return *features_;
}

}  // namespace feder
