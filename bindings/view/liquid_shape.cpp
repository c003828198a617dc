#include "view/liquid_shape.h"

#include <algorithm>
#include <cmath>

#include "base/checks.h"

namespace feder::view {
namespace {

constexpr Real kCell = Real(2.4);                               // spacings
constexpr std::uint32_t kLoose = 5;                             // in eight cells, which have 110 in a liquid at rest
constexpr Real kShrink = Real(0.5), kSwell = Real(-0.53);       // shares of the way, Taubin's lambda and mu
constexpr Real kFull = Real(2.5);                               // calm differences, at which all is foam
constexpr std::int64_t kBias = 1 << 20, kMask = (1 << 21) - 1;  // cells by 21 bits an axis

std::uint64_t packed(const std::int64_t (&c)[3]) {
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k) key = key << 21 | static_cast<std::uint64_t>((c[k] + kBias) & kMask);
  return key;
}

std::size_t slot_of(std::uint64_t key, std::size_t mask) {
  return static_cast<std::size_t>(key * 0x9e3779b97f4a7c15u >> 32) & mask;
}

}  // namespace

std::uint64_t LiquidShape::key_of(const Vec3& x) const {
  std::int64_t c[3];
  for (int k = 0; k < 3; ++k) c[k] = static_cast<std::int64_t>(std::floor(std::clamp<Real>(x[k] / size_, -1e6f, 1e6f)));
  return packed(c);
}

const LiquidShape::Cell* LiquidShape::find(std::uint64_t key) const {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t at = slot_of(key, mask); slots_[at] != kNone; at = (at + 1) & mask)
    if (cells_[slots_[at]].key == key) return &cells_[slots_[at]];
  return nullptr;
}

std::uint32_t LiquidShape::make(std::uint64_t key) {
  if (2 * (cells_.size() + 1) > slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = slot_of(key, mask);
  for (; slots_[at] != kNone; at = (at + 1) & mask)
    if (cells_[slots_[at]].key == key) return slots_[at];
  slots_[at] = static_cast<std::uint32_t>(cells_.size());
  cells_.emplace_back().key = key;
  return slots_[at];
}

void LiquidShape::grow() {
  slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kNone);
  const std::size_t mask = slots_.size() - 1;
  for (std::uint32_t i = 0; i < cells_.size(); ++i) {
    std::size_t at = slot_of(cells_[i].key, mask);
    while (slots_[at] != kNone) at = (at + 1) & mask;
    slots_[at] = i;
  }
}

// Of the eight cells that meet nearest to it.
bool LiquidShape::is_spray(const Vec3& x) const {
  std::int64_t low[3];
  for (int k = 0; k < 3; ++k) {
    const Real at = x[k] / size_;
    if (std::abs(at) > 1e6f) return true;
    low[k] = static_cast<std::int64_t>(std::floor(at - Real(0.5)));
  }
  std::uint32_t near = 0;
  for (int i = 0; i < 8; ++i) {
    const std::int64_t c[3] = {low[0] + (i & 1), low[1] + (i >> 1 & 1), low[2] + (i >> 2)};
    if (const Cell* cell = find(packed(c))) near += cell->count;
    if (near > kLoose) return false;
  }
  return true;
}

void LiquidShape::sort(std::span<const Vec3> positions, std::span<const Vec3> velocities, Real spacing, Real calm) {
  FEDER_ASSERT(spacing > 0 && (calm <= 0 || velocities.size() == positions.size()));
  size_ = kCell * spacing, foams_ = false;
  cells_.clear(), own_.clear();
  std::fill(slots_.begin(), slots_.end(), kNone);
  if (slots_.empty()) grow();
  std::uint64_t last_key = 0;
  std::uint32_t last = kNone;  // neighbours in the list are mostly in one cell
  for (std::size_t i = 0; i < positions.size(); ++i) {
    own_.push_back(kNone);
    if (!is_finite(positions[i])) continue;
    const std::uint64_t key = key_of(positions[i]);
    if (last == kNone || key != last_key) last = make(key), last_key = key;
    own_.back() = last;
    Cell& c = cells_[last];
    ++c.count;
    if (calm > 0) c.sum += velocities[i], c.squares += velocities[i].squaredNorm();
  }
  if (calm > 0)
    for (Cell& c : cells_) {
      if (c.count < 2) continue;
      const Real n = static_cast<Real>(c.count), spread = c.squares / n - (c.sum / n).squaredNorm();
      const Real differ = std::sqrt(std::max(spread, Real(0))) / calm;
      c.foam = static_cast<float>(std::clamp((differ - 1) / (kFull - 1), Real(0), Real(1)));
      foams_ |= c.foam > 0;
    }
  bulk_.clear(), spray_.clear();
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (own_[i] != kNone)
      (cells_[own_[i]].count <= kLoose && is_spray(positions[i]) ? spray_ : bulk_).push_back(positions[i]);
}

float LiquidShape::foam(const Vec3& at) const {
  const Cell* c = find(key_of(at));
  return c ? c->foam : 0;
}

void smooth_mesh(std::span<Vec3> vertices, std::span<const std::uint32_t> triangles, std::span<float> foam, int rounds,
                 std::vector<Vec3>& scratch, std::vector<float>& weights) {
  FEDER_ASSERT(foam.empty() || foam.size() == vertices.size());
  // of a closed mesh, every neighbour comes twice
  weights.assign(vertices.size(), 0);
  for (const std::uint32_t v : triangles) weights[v] += 2;
  for (int sweep = 0; sweep < 2 * rounds; ++sweep) {
    scratch.assign(vertices.size(), Vec3::Zero());
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
      const std::uint32_t i = triangles[t], j = triangles[t + 1], k = triangles[t + 2];
      const Vec3 all = vertices[i] + vertices[j] + vertices[k];
      scratch[i] += all - vertices[i], scratch[j] += all - vertices[j], scratch[k] += all - vertices[k];
    }
    const Real share = sweep % 2 == 0 ? kShrink : kSwell;
    for (std::size_t i = 0; i < vertices.size(); ++i)
      if (weights[i] > 0) vertices[i] += share * (scratch[i] / static_cast<Real>(weights[i]) - vertices[i]);
  }
  if (foam.empty()) return;
  for (int sweep = 0; sweep < rounds; ++sweep) {
    scratch.assign(vertices.size(), Vec3::Zero());
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
      const std::uint32_t i = triangles[t], j = triangles[t + 1], k = triangles[t + 2];
      scratch[i][0] += foam[j] + foam[k], scratch[j][0] += foam[k] + foam[i], scratch[k][0] += foam[i] + foam[j];
    }
    for (std::size_t i = 0; i < foam.size(); ++i)
      if (weights[i] > 0) foam[i] = static_cast<float>(scratch[i][0]) / weights[i];
  }
}

}  // namespace feder::view
