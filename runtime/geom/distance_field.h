// Distances on a grid and what lies between them: trilinear. Dense (a float per corner), or adaptive: an octree whose
// leaves are bricks of 4 x 4 x 4 cells, of the finest spacing near the surface and of doubled spacings away from it,
// each with its own scale and 16 bits per corner. Source: Frisken, Perry, Rockwood & Jones, "Adaptively Sampled
// Distance Fields", SIGGRAPH 2000, with bricks for leaves.
// Error of a dense field of exact distances, q the distance to the medial axis or a sharp edge, h the spacing: at most
// 1.1 h^2/(4 q) where q >= 3 h, .9 h elsewhere (tests/geom/test_sdf.cpp). Outside of its box: the distance to the
// nearest surface point of the place in the box that is nearest.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "feder/types.h"

namespace feder {

struct FieldLayout {
  Vec3 origin = Vec3::Zero();  // m, of the corner 0, 0, 0
  Real spacing = 1;            // m
  int n[3] = {0, 0, 0};        // corners along x, y, z, at least two

  std::size_t corners() const { return stride(3); }
  std::size_t stride(int axis) const {  // of numbers of corners; 3: all of them
    std::size_t s = 1;
    for (int k = 0; k < axis; ++k) s *= static_cast<std::size_t>(n[k]);
    return s;
  }
  std::size_t index(int x, int y, int z) const {
    return std::size_t(x) + std::size_t(n[0]) * (std::size_t(y) + std::size_t(n[1]) * std::size_t(z));
  }
  void place_of(std::size_t index, int (&at)[3]) const {
    const auto row = std::size_t(n[0]), rows = std::size_t(n[1]);
    at[0] = static_cast<int>(index % row), at[1] = static_cast<int>(index / row % rows);
    at[2] = static_cast<int>(index / row / rows);
  }
  // Corners within `reach` of a box; lo above hi along an axis: none.
  void range(const Aabb& box, Real reach, int (&lo)[3], int (&hi)[3]) const;
  // value(x, y, z) of all corners, x fastest.
  template <class F>
  std::vector<float> values(F&& value) const {
    std::vector<float> out;
    out.reserve(corners());
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) out.push_back(static_cast<float>(value(x, y, z)));
    return out;
  }
  Vec3 corner(int x, int y, int z) const { return origin + spacing * Vec3(Real(x), Real(y), Real(z)); }
  Aabb box() const { return {origin, corner(n[0] - 1, n[1] - 1, n[2] - 1)}; }
};

class DistanceField {
 public:
  DistanceField() = default;
  DistanceField(const FieldLayout& layout, std::vector<float> values);  // x fastest

  // Bricks as they are found, top down, by asking distance(context, p). Where |distance| is above `band`, cells grow as
  // long as what lies between their corners is off by no more than an eighth of the distance; nearer, a cell is finest
  // unless `tolerance` (m) is above 0 and kept at its middle. The layout is rounded up to whole bricks.
  using Distance = Real (*)(const void* context, const Vec3& p);
  static DistanceField adaptive(FieldLayout layout, Real band, Real tolerance, Distance distance, const void* context);

  Real at(const Vec3& p) const;
  // No more than at(p), which it is within the box: outside, the way to the box and on to the surface at right angles.
  Real at_least(const Vec3& p) const;
  // at(p), or where at_least(p) is above the limit that.
  Real within(const Vec3& p, Real limit) const {
    const Real least = at_least(p);
    return least > limit ? least : at(p);
  }
  Real at(const Vec3& p, Vec3& slope) const;  // the gradient of what is interpolated: nearly of length 1
  // The slope as the mean over a cell around p: continuous, and exact for a field of second order.
  Real smooth_at(const Vec3& p, Vec3& slope) const;

  const FieldLayout& layout() const { return layout_; }
  bool is_adaptive() const { return levels_ >= 0; }
  std::size_t bytes() const;
  const std::vector<float>& values() const { return values_; }  // of a dense one

  // Bytes from which an equal field is made; SceneError for others.
  std::string content() const;
  static DistanceField from_content(std::string_view bytes);

 private:
  static constexpr int kCells = 4, kCorners = kCells + 1, kBrick = kCorners * kCorners * kCorners;
  static constexpr std::uint32_t kLeaf = 0x80000000u;
  struct Cell {
    Real v[8];   // x fastest
    Real at[3];  // 0..1
    Real size;   // m
  };
  void cell_of(const Vec3& u, Cell& cell) const;  // u: in cells of the finest spacing, within the box
  void brick_cell(const Vec3& u, Cell& cell) const;
  Real inside(const Vec3& p, Vec3* slope) const;
  struct Builder;
  bool dense_slope(const Vec3& u, Vec3& slope) const;
  void check() const;

  FieldLayout layout_;
  Real inverse_ = 1;  // of the spacing, 1/m
  std::vector<float> values_;
  // adaptive
  int levels_ = -1;  // between a root and the finest bricks
  int roots_[3] = {0, 0, 0};
  std::vector<std::uint32_t> nodes_;  // roots first, x fastest; kLeaf | brick, or the first of eight children
  std::vector<float> scale_;          // by brick, m
  std::vector<std::uint8_t> level_;   // by brick
  std::vector<std::int16_t> bricks_;
};

}  // namespace feder
