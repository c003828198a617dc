#include "fluid/liquid_surface.h"

#include <algorithm>
#include <cmath>

#include "base/checks.h"

namespace feder {
namespace {

constexpr Real kFineCell = Real(0.5), kMiddleCell = Real(0.8), kCoarseCell = 1, kReach = Real(1.6),
               kBall = Real(0.55);                               // spacings
constexpr std::size_t kMostFine = 15'000, kMostMiddle = 60'000;  // particles; any takes 20 ms of one core at most
constexpr double kMostBlocks = 1 << 22;
constexpr double kKept = 1.5;         // standard deviations; of an even spread all lies within 1.74
constexpr Real kCoarse = Real(2.4);   // spacings, of a cell that tells what lies deep
constexpr int kFull = 7;              // particles in it; 14 at rest, 8 at least in a lattice
constexpr Real kAround = Real(1.05);  // spacings about a deep particle that lie inside

// Without a call, as the library's are where the processor may be of 2003.
int floored(Real x) {
  const int i = static_cast<int>(x);
  return i - (static_cast<Real>(i) > x ? 1 : 0);
}
int ceiled(Real x) { return -floored(-x); }

}  // namespace

// The grid around the particles; where that has too many blocks, around the middle of them.
void LiquidSurface::bound(std::span<const Vec3> positions, Real spacing) {
  low_ = Vec3::Constant(-kInfinity), high_ = Vec3::Constant(kInfinity);
  reach_ = kReach * spacing, ball_ = kBall * spacing;
  grid_ = IsoGrid{};
  const std::size_t count = positions.size();
  grid_.cell = (count <= kMostFine ? kFineCell : count <= kMostMiddle ? kMiddleCell : kCoarseCell) * spacing;
  coarse_size_ = kCoarse * spacing;
  for (;;) {
    Vec3 lo = Vec3::Constant(kInfinity), hi = Vec3::Constant(-kInfinity);
    double mean[3] = {0, 0, 0}, square[3] = {0, 0, 0}, n = 0;
    for (const Vec3& x : positions) {
      if (!is_finite(x) || (x.array() < low_.array()).any() || (x.array() > high_.array()).any()) continue;
      lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
      for (int k = 0; k < 3; ++k)
        mean[k] += static_cast<double>(x[k]), square[k] += std::pow(static_cast<double>(x[k]), 2);
      ++n;
    }
    if (n == 0) return;
    double blocks = 1;
    for (int k = 0; k < 3; ++k)
      blocks *= std::floor(static_cast<double>((hi[k] - lo[k] + 2 * reach_) / grid_.cell) / IsoGrid::kBlock) + 1;
    low_ = lo, high_ = hi;
    if (blocks <= kMostBlocks) break;
    for (int k = 0; k < 3; ++k) {
      const double m = mean[k] / n, spread = std::sqrt(std::max(0.0, square[k] / n - m * m));
      const double keep = std::max(kKept * spread, static_cast<double>(spacing));
      low_[k] = std::max(low_[k], static_cast<Real>(m - keep)),
      high_[k] = std::min(high_[k], static_cast<Real>(m + keep));
    }
    if ((low_.array() <= lo.array()).all() && (high_.array() >= hi.array()).all()) {
      low_ = Vec3::Constant(kInfinity);  // nothing is far from the middle, so none of it is inside
      return;
    }
  }
  grid_.origin = low_ - Vec3::Constant(reach_ + grid_.cell);
  for (int k = 0; k < 3; ++k)
    grid_.n[k] = static_cast<int>(std::ceil((high_[k] - low_[k] + 2 * reach_) / grid_.cell)) + 3;
}

std::size_t LiquidSurface::coarse_of(const Vec3& x) const {
  std::size_t at[3];
  for (int k = 0; k < 3; ++k) at[k] = static_cast<std::size_t>((x[k] - grid_.origin[k]) / coarse_size_);
  return at[0] + static_cast<std::size_t>(coarse_[0]) * (at[1] + static_cast<std::size_t>(coarse_[1]) * at[2]);
}

// Coarse cells that are full, and then which of those lie among full ones: nothing of the surface is nearer to a
// particle there than 2.4 spacings, so no distance is asked for.
void LiquidSurface::find_deep(std::span<const Vec3> positions) {
  std::size_t size = 1;
  for (int k = 0; k < 3; ++k)
    coarse_[k] = static_cast<int>(static_cast<Real>(grid_.n[k]) * grid_.cell / coarse_size_) + 1,
    size *= static_cast<std::size_t>(coarse_[k]);
  full_.assign(size, 0);
  for (const Vec3& x : positions) {
    if (!inside_box(x)) continue;
    std::uint8_t& n = full_[coarse_of(x)];
    n = static_cast<std::uint8_t>(std::min(n + 1, 255));
  }
  for (std::uint8_t& n : full_) n = n >= kFull;
  // all of three in a row along x, then y, then z; in place, as what lies behind has been read
  const std::size_t steps[3] = {1, static_cast<std::size_t>(coarse_[0]),
                                static_cast<std::size_t>(coarse_[0]) * static_cast<std::size_t>(coarse_[1])};
  for (const std::size_t step : steps) {
    deep_.assign(size, 0);
    for (std::size_t i = step; i + step < size; ++i) deep_[i] = full_[i - step] & full_[i] & full_[i + step];
    full_.swap(deep_);
  }
  full_.swap(deep_);
}

template <class F>
void LiquidSurface::each_block(const Vec3& x, F&& f) const {
  if (!inside_box(x)) return;
  int first[3], last[3];
  for (int k = 0; k < 3; ++k) {
    // a block has the corners at both of its ends
    const Real at = (x[k] - grid_.origin[k]) / grid_.cell, far = reach_ / grid_.cell;
    const int lo = ceiled(at - far), hi = floored(at + far);
    first[k] = std::max(0, (lo + IsoGrid::kBlock - 1) / IsoGrid::kBlock - 1);
    last[k] = std::min(grid_.blocks(k) - 1, hi / IsoGrid::kBlock);
  }
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int b = first[0]; b <= last[0]; ++b)
        f(static_cast<std::uint32_t>(b + grid_.blocks(0) * (y + grid_.blocks(1) * z)));
}

template <int kWide>
void LiquidSurface::sum_up(std::span<const Vec3> positions, const IsoBlock& block, std::uint32_t index) {
  constexpr int n = IsoBlock::kCorners, row = IsoBlock::kRow, layer = IsoBlock::kLayer;
  std::fill_n(marked_, n, false);
  for (Real* sums : {weight_, x_, y_, z_}) std::fill_n(sums, kPadded, Real(0));
  const Real cell = grid_.cell, inverse = 1 / (reach_ * reach_), far = reach_ / cell, around = kAround / kReach * far;
  Vec3 origin;
  for (int k = 0; k < 3; ++k) origin[k] = grid_.coordinate(k, block.first[k]);
  for (std::uint32_t at = first_[index]; at < first_[index + 1]; ++at) {
    const Vec3 p = positions[members_[at]] - origin;
    const auto range = [&](Real u, int& lo, int& hi) {
      lo = std::max(0, ceiled(u / cell - far));
      hi = std::min(row - 1, floored(u / cell + far));
    };
    int x0, x1, y0, y1, z0, z1;
    if (deep_[coarse_of(positions[members_[at]])]) {
      const auto near = [&](Real u, int& lo, int& hi) {
        lo = std::max(0, ceiled(u / cell - around));
        hi = std::min(row - 1, floored(u / cell + around));
      };
      near(p[0], x0, x1), near(p[1], y0, y1), near(p[2], z0, z1);
      for (int z = z0; z <= z1; ++z)
        for (int y = y0; y <= y1; ++y)
          for (int x = x0; x <= x1; ++x) marked_[x + row * y + layer * z] = true;
      continue;
    }
    range(p[1], y0, y1), range(p[2], z0, z1);
    // as many in a row as it reaches, but for one more whose weight is zero
    x0 = std::clamp(ceiled(p[0] / cell - far), -kPad, row);
    const Real from = p[0] - static_cast<Real>(x0) * cell;
    for (int z = z0; z <= z1; ++z) {
      const Real dz = p[2] - static_cast<Real>(z) * cell;
      for (int y = y0; y <= y1; ++y) {
        const Real dy = p[1] - static_cast<Real>(y) * cell, left = 1 - (dy * dy + dz * dz) * inverse;
        if (!(left > 0)) continue;
        const int begin = kStride * (y + row * z) + kPad + x0;
        for (int x = 0; x < kWide; ++x) {
          const Real dx = from - static_cast<Real>(x) * cell, q = std::max(left - dx * dx * inverse, Real(0));
          const Real w = q * q * q;
          weight_[begin + x] += w, x_[begin + x] += w * dx, y_[begin + x] += w * dy, z_[begin + x] += w * dz;
        }
      }
    }
  }
}

// Half a spacing less the distance from the mean of the particles near.
void LiquidSurface::sample(std::span<const Vec3> positions, const IsoBlock& block, std::uint32_t index, Real* values) {
  static_assert(2 * kReach <= 4 * kMiddleCell && 2 * kReach <= 8 * kFineCell);
  constexpr int row = IsoBlock::kRow, layer = IsoBlock::kLayer;
  if (positions.size() <= kMostFine)
    sum_up<8>(positions, block, index);
  else
    sum_up<4>(positions, block, index);
  for (int line = 0; line < layer; ++line)
    for (int x = 0; x < row; ++x) {
      const int k = kStride * line + kPad + x, to = row * line + x;
      const Real w = weight_[k], away = std::sqrt(x_[k] * x_[k] + y_[k] * y_[k] + z_[k] * z_[k]);
      values[to] = marked_[to] ? ball_ : w > 0 ? ball_ - away / w : -ball_;
    }
}

void LiquidSurface::build(std::span<const Vec3> positions, Real spacing, bool with_normals, IsoMesh& mesh) {
  FEDER_ASSERT(spacing > 0);
  bound(positions, spacing);
  const std::uint32_t blocks = grid_.block_count();
  find_deep(positions);
  first_.assign(blocks + 1u, 0);
  for (const Vec3& x : positions) each_block(x, [&](std::uint32_t b) { ++first_[b + 1]; });
  occupied_.clear();
  for (std::uint32_t b = 0; b < blocks; ++b) {
    if (first_[b + 1] > 0) occupied_.push_back(b);
    first_[b + 1] += first_[b];
  }
  members_.resize(first_[blocks]);
  for (std::uint32_t i = 0; i < positions.size(); ++i)
    each_block(positions[i], [&](std::uint32_t b) { members_[first_[b]++] = i; });
  for (std::uint32_t b = blocks; b > 0; --b) first_[b] = first_[b - 1];
  if (blocks > 0) first_[0] = 0;
  std::size_t next = 0;
  surface_.extract_blocks(
      grid_, occupied_,
      [&](const IsoBlock& block, Real* values) { sample(positions, block, occupied_[next++], values); }, 0,
      with_normals, mesh);
}

}  // namespace feder
