// Greedy colouring of tetrahedra: a colour holds some that share no point, so its lanes and batches may run in any
// order and on any thread, with the same bits. At a point of more than 64 tetrahedra the rest get colours of their own
// of one lane each. The fastest mode of the body by power iteration; that of a tetrahedron alone, with its own share of
// the masses, bounds it from above (Irons and Treharne 1971). Kept between calls: colours, batches and these numbers,
// by version. Weak spot: flat tetrahedra are stiff; those that are stiffest and make up a few thousandths of the volume
// are taken as softer than they are, so that not all of the body pays for them; where a region is of such, as in a
// graded mesh, it keeps 98 % of its stiffness, and the body pays.
#include "soft/batches.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/wide.h"
#include "soft/stability.h"

namespace feder {
namespace {
constexpr JobGrain kTetGrain{32, 5'000};  // batches per job
constexpr std::uint32_t kColors = 64;
constexpr double kSpared = 2e-3;      // of the volume times its stiffness: what may be lost at stiff tetrahedra
constexpr double kSparedNear = 0.02;  // likewise, of the tetrahedra round a point
constexpr double kMostRoom = 1e12;
constexpr int kIterations = 40;          // of the power method
constexpr double kUnderestimate = 1.05;  // of its result
}  // namespace

void SoftBatches::pick([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) kernels_ = &kTetKernelsAvx2;
#endif
}

std::uint32_t SoftBatches::color(const SoftView& v) {
  const auto& tetrahedra = v.mesh->tetrahedra;
  std::vector<std::uint64_t> used(v.points, 0);
  color_.resize(tetrahedra.size());
  std::uint32_t count = 0, alone = 0;
  for (std::size_t k = 0; k < tetrahedra.size(); ++k) {
    std::uint64_t taken = 0;
    for (const std::uint32_t i : tetrahedra[k]) taken |= used[i];
    if (taken == ~std::uint64_t(0)) {
      color_[k] = kColors + alone++;
      continue;
    }
    const auto free = static_cast<std::uint32_t>(__builtin_ctzll(~taken));
    for (const std::uint32_t i : tetrahedra[k]) used[i] |= std::uint64_t(1) << free;
    color_[k] = free;
    count = std::max(count, free + 1);
  }
  for (std::uint32_t& c : color_)
    if (c >= kColors) c = count + (c - kColors);
  return count + alone;
}

void SoftBatches::build(const SoftView& v) {
  if (version_ == v.version) {
    if (shape_ != v.shape) reshape(v);
    return;
  }
  version_ = v.version;
  const SoftMesh& m = *v.mesh;
  const std::uint32_t spare = v.points, count = color(v);
  TetBatch empty{};
  for (auto& row : empty.v) std::fill(row, row + kLanes, spare);
  for (int i = 0; i < kLanes; ++i) {  // a tetrahedron of unit edges without volume
    empty.gradient[0].x.v[i] = empty.gradient[1].y.v[i] = empty.gradient[2].z.v[i] = 1;
    empty.base[0].x.v[i] = empty.base[1].y.v[i] = empty.base[2].z.v[i] = 1;
    empty.share.v[i] = 1, empty.room.v[i] = static_cast<Real>(kMostRoom);
  }
  // tetrahedra by colour, in the order of their numbers
  std::vector<std::vector<std::uint32_t>> of(count);
  for (std::uint32_t k = 0; k < color_.size(); ++k) of[color_[k]].push_back(k);
  tets_.clear(), colors_.clear(), lane_.clear();
  for (const auto& list : of) {
    const auto first = static_cast<unsigned>(tets_.size());
    int lane = kLanes;
    for (const std::uint32_t k : list) {
      if (lane == kLanes) tets_.push_back(empty), lane_.resize(tets_.size() * kLanes, kNone), lane = 0;
      TetBatch& b = tets_.back();
      for (std::size_t c = 0; c < 4; ++c) b.v[c][lane] = m.tetrahedra[k][c];
      b.volume.v[lane] = m.volume[k];
      lane_[(tets_.size() - 1) * kLanes + static_cast<std::size_t>(lane)] = k;
      ++lane;
    }
    colors_.push_back({first, static_cast<unsigned>(tets_.size())});
  }
  flagged_.assign(tets_.size(), 0);
  damping_.clear();
  measure(v);
  reshape(v);
}

// Gradients as they are now, and the bounds that follow: what flows answers more, all of the body at most by as much as
// the tetrahedron that does so most.
void SoftBatches::reshape(const SoftView& v) {
  shape_ = v.shape;
  const SoftMesh& m = *v.mesh;
  const auto more = [&](std::uint32_t k) { return m.stiffening.empty() ? 1.0 : double(m.stiffening[k]); };
  double most = 0, growth = 1;
  for (std::uint32_t k = 0; k < rate_.size(); ++k)
    most = std::fmax(most, rate_[k] * more(k)), growth = std::fmax(growth, more(k));
  stiffest_ = most * rest_stiffness(v.material), fastest_ = std::fmin(stiffest_, at_first_ * growth);
  for (std::size_t n = 0; n < lane_.size(); ++n) {
    const std::uint32_t k = lane_[n];
    if (k == kNone) continue;
    TetBatch& b = tets_[n / kLanes];
    const std::size_t lane = n % kLanes;
    for (std::size_t c = 0; c < 3; ++c) {
      const Real* g = &m.inverse[9 * std::size_t(k) + 3 * c];
      b.gradient[c].x.v[lane] = g[0], b.gradient[c].y.v[lane] = g[1], b.gradient[c].z.v[lane] = g[2];
    }
    b.room.v[lane] = static_cast<Real>(std::fmin(most / (rate_[k] * more(k)), kMostRoom));
  }
}

void SoftBatches::measure(const SoftView& v) {
  const SoftMesh& m = *v.mesh;
  const std::size_t n = m.tetrahedra.size();
  rate_.resize(n);
  std::vector<std::uint32_t> order(n);
  for (std::uint32_t k = 0; k < n; ++k)
    order[k] = k, rate_[k] = 4 / v.density * gradient_bound(barycentric_gradients(m.rest_corners(k)));
  // the stiffest tetrahedra count as softer, as far as the body does not notice
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return rate_[a] != rate_[b] ? rate_[a] > rate_[b] : a < b; });
  double cut = rate_[order[0]], volume = 0, weighed = 0;  // sums over those beyond: V, and V/rate
  for (std::size_t k = 0; k + 1 < n; ++k) {
    volume += double(m.volume[order[k]]), weighed += double(m.volume[order[k]]) / rate_[order[k]];
    const double next = rate_[order[k + 1]];
    if (volume - next * weighed > kSpared * m.rest_volume) {
      cut = std::min(cut, (volume - kSpared * m.rest_volume) / weighed);
      break;
    }
    cut = next;
  }
  std::vector<double> around(v.points, 0), lost(v.points, 0), scale(n);  // m^3, by point
  for (std::size_t k = 0; k < n; ++k) {
    scale[k] = std::fmin(1, cut / rate_[k]);
    for (const std::uint32_t i : m.tetrahedra[k])
      around[i] += double(m.volume[k]), lost[i] += (1 - scale[k]) * double(m.volume[k]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    double most = 0;
    for (const std::uint32_t i : m.tetrahedra[k]) most = std::fmax(most, lost[i] / around[i]);
    if (most > kSparedNear) scale[k] = 1 - (1 - scale[k]) * kSparedNear / most;
  }
  for (std::size_t k = 0; k < n; ++k) rate_[k] *= scale[k];
  for (std::size_t l = 0; l < lane_.size(); ++l)
    if (lane_[l] != kNone) tets_[l / kLanes].volume.v[l % kLanes] *= static_cast<Real>(scale[lane_[l]]);
  at_first_ = kUnderestimate * fastest_mode(m, v.points, v.material, v.density, scale, kIterations);
}

void SoftBatches::set_step(const SoftView& v, Real h, double share) {
  share_ = share;
  carried_ = kCarried * rest_stiffness(v.material) / (fastest_ * double(h) * double(h));
}

void SoftBatches::current_position(const SoftView& v) {
  for (TetBatch& b : tets_)
    for (int i = 0; i < kLanes; ++i) {
      if (b.v[0][i] == v.points) continue;  // an empty lane
      const Vec3& from = v.position[b.v[0][i]];
      for (int k = 0; k < 3; ++k) {
        const Vec3 e = v.position[b.v[k + 1][i]] - from;
        b.base[k].x.v[i] = e[0], b.base[k].y.v[i] = e[1], b.base[k].z.v[i] = e[2];
      }
    }
}

TetPass SoftBatches::pass(const SoftView& v, Real h) {
  FEDER_ASSERT(version_ == v.version && h > 0);
  TetPass p{};
  p.tets = tets_.data(), p.flagged = flagged_.data();
  p.delta_position = &v.delta_position->x, p.velocity = &v.velocity->x;
  p.h = h;
  p.mu = static_cast<Real>(share_ * v.material.mu), p.lame = static_cast<Real>(share_ * v.material.lame);
  p.shear = static_cast<Real>(share_ * v.material.shear), p.lambda = static_cast<Real>(share_ * v.material.lambda);
  p.gamma = static_cast<Real>(v.material.gamma);
  p.carried = static_cast<Real>(carried_);
  return p;
}

void SoftBatches::run(Kernel kernel, const TetPass& pass, StepContext& c) {
  for_colors(colors_, kTetGrain, stages_, *c.jobs, [&](std::uint32_t first, std::uint32_t last, int) {
    TetPass part = pass;
    part.first = first, part.last = last;
    kernel(part);
  });
}

bool SoftBatches::push(const SoftView& v, Real time, StepContext& c) {
  run(kernels_->push, pass(v, time), c);
  return std::find(flagged_.begin(), flagged_.end(), 1) != flagged_.end();
}

void SoftBatches::solve_remainder(const SoftView& v, Real h, StepContext& c) {
  run(kernels_->remainder, pass(v, h), c);
}

void SoftBatches::validate(const SoftView& v) const {
  if (version_ != v.version) return;
  const auto& tetrahedra = v.mesh->tetrahedra;
  // no colour names a point twice, and lanes are tetrahedra, each once: their number and the sum of their numbers
  marks_.assign(v.points, kNone);
  std::uint64_t found = 0, sum = 0;
  for (std::uint32_t k = 0; k < colors_.size(); ++k)
    for (std::size_t n = colors_[k].first * std::size_t(kLanes); n < colors_[k].last * std::size_t(kLanes); ++n) {
      const TetBatch& b = tets_[n / kLanes];
      for (std::size_t c = 0; c < 4; ++c)
        FEDER_ASSERT(b.v[c][n % kLanes] == (lane_[n] == kNone ? v.points : tetrahedra[lane_[n]][c]));
      if (lane_[n] == kNone) continue;
      ++found, sum += lane_[n];
      for (const std::uint32_t i : tetrahedra[lane_[n]]) {
        FEDER_ASSERT(marks_[i] != k);
        marks_[i] = k;
      }
    }
  const std::uint64_t count = tetrahedra.size();
  FEDER_ASSERT(found == count && sum == count * (count - 1) / 2);
}

}  // namespace feder
