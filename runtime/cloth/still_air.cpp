#include "cloth/still_air.h"

#include <algorithm>
#include <limits>

#include "base/wide.h"
#include "forces/area.h"

namespace feder {
namespace {
constexpr JobGrain kAirBatches{128, 8'000}, kAirPoints{1024, 8'000};
}  // namespace

void StillAir::pick([[maybe_unused]] bool wide) {
  kernels_ = &kClothKernelsPlain;
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) kernels_ = &kClothKernelsAvx2;
#endif
}

void StillAir::build(const ClothMesh& mesh, std::uint32_t points, std::uint32_t spare, std::uint64_t version) {
  if (version_ == version) return;
  FEDER_ASSERT(spare >= points && mesh.triangles.size() % 3 == 0);
  version_ = version, points_ = points, spare_ = spare;
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size() / 3);
  batches_.resize((count + kLanes - 1) / kLanes);
  for (std::uint32_t t = 0; t < batches_.size() * kLanes; ++t)
    for (std::uint32_t k = 0; k < 3; ++k)
      batches_[t / kLanes].v[k][t % kLanes] = t < count ? mesh.triangles[3 * t + k] : spare;
  first_.assign(points + 1, 0), round_.resize(3 * count);
  for (const std::uint32_t i : mesh.triangles) ++first_[i + 1];
  for (std::uint32_t i = 0; i < points; ++i) first_[i + 1] += first_[i];
  for (std::uint32_t k = 0; k < mesh.triangles.size(); ++k) round_[first_[mesh.triangles[k]]++] = k / 3;
  for (std::uint32_t i = points; i > 0; --i) first_[i] = first_[i - 1];
  first_[0] = 0;
  now_.resize(spare + 1), push_.resize(batches_.size() * kLanes);
  taken_.resize(batches_.size() / kAirBatches.items + 1);
}

Real StillAir::meet(const Flow& f, Vec3* force, JobPool& jobs) {
  FEDER_ASSERT(f.density > 0 && f.most > 0 && now_.size() == spare_ + 1);
  jobs.for_blocks(points_, kAirPoints, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) now_[i].set(f.position[i] + f.delta_position[i].vec());
  });
  std::fill(taken_.begin(), taken_.end(), Real(0));
  jobs.for_blocks(static_cast<std::uint32_t>(batches_.size()), kAirBatches,
                  [&](std::uint32_t first, std::uint32_t last, int) {
                    AirPass p{};
                    p.batches = batches_.data(), p.first = first, p.last = last;
                    p.position = &now_[0].x, p.velocity = &f.velocity->x, p.weights = &f.delta_position->x;
                    p.push = &push_[0].x;
                    p.density = f.density, p.most = f.most, p.drag = f.drag, p.lift = f.lift, p.skin = kSkin;
                    p.least = std::numeric_limits<Real>::min(), p.largest = std::numeric_limits<Real>::max();
                    kernels_->still_air(p);
                    taken_[first / kAirBatches.items] = p.taken;
                  });
  jobs.for_blocks(points_, kAirPoints, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      Vec3 sum = Vec3::Zero();
      for (std::uint32_t k = first_[i]; k < first_[i + 1]; ++k) sum += push_[round_[k]].vec();
      force[i] = sum;
    }
  });
  return *std::max_element(taken_.begin(), taken_.end());
}

}  // namespace feder
