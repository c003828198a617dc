// The surface of a liquid as triangles, for drawing, export and scripts.
#pragma once
#include "base/checks.h"
#include "geom/isosurface.h"

namespace feder {

// By the distance from the mean place of the particles near, weighed by (1 - r^2/R^2)^3 (Zhu & Bridson, "Animating Sand
// as a Fluid", TOG 2005, eq. 1-3): a lone particle is a ball of half a spacing, flat rows give a flat surface. Marching
// cubes in blocks where particles are, with cells of half a spacing up to kMostFine particles, of .8 up to kMostMiddle,
// of one beyond. Kept between calls: memory. Weak spots: hollows narrower than a spacing fill up; a liquid strewn so
// widely that its box holds more than kMostBlocks blocks shows only what lies in the middle of it, or nothing.
class LiquidSurface {
 public:
  // Replaces the content of the mesh; m. Positions that are not finite are left out.
  void build(std::span<const Vec3> positions, Real spacing, bool with_normals, IsoMesh& mesh);

 private:
  void bound(std::span<const Vec3> positions, Real spacing);
  void find_deep(std::span<const Vec3> positions);
  bool inside_box(const Vec3& x) const {
    return is_finite(x) && (x.array() >= low_.array()).all() && (x.array() <= high_.array()).all();
  }
  std::size_t coarse_of(const Vec3& x) const;
  template <class F>
  void each_block(const Vec3& x, F&& f) const;  // f(block) for those that the particle reaches
  void sample(std::span<const Vec3> positions, const IsoBlock& block, std::uint32_t index, Real* values);

  IsoGrid grid_;
  Real reach_ = 0, ball_ = 0;  // m
  Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();
  IsoSurface surface_;
  std::vector<std::uint32_t> first_;       // of a block, in members_; one more than there are
  std::vector<std::uint32_t> members_;     // particles by block
  std::vector<std::uint32_t> occupied_;    // blocks, ascending
  std::vector<std::uint8_t> full_, deep_;  // by coarse cell
  int coarse_[3] = {0, 0, 0};
  Real coarse_size_ = 0;  // m
  bool marked_[IsoBlock::kCorners];
  // kWide: corners that a particle reaches in a row.
  template <int kWide>
  void sum_up(std::span<const Vec3> positions, const IsoBlock& block, std::uint32_t index);
  // Sums of a block's corners, with room for those that a particle reaches in a row.
  static constexpr int kPad = 8, kStride = IsoBlock::kRow + 2 * kPad, kPadded = kStride * IsoBlock::kLayer;
  Real weight_[kPadded], x_[kPadded], y_[kPadded], z_[kPadded];
};

}  // namespace feder
