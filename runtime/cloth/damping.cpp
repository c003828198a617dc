// Damping of strain rate, once per substep (bending by stages: once per step where they carry that), at velocities: M
// v' = -tau K v over h with the stiffness K of hinges and links, so that a mode of frequency w decays at tau w^2/2
// (Kelvin-Voigt). The modes of a sheet spread over many decades (a strip of n segments: w^2 grows with n^4), and one
// sweep in which each hinge is implicit by itself carries damping across a hinge or two only: it is what a fine sheet
// gets when h tau w^2 of its fastest mode is small. Else hinges are damped by stages of an explicit
// Runge-Kutta-Chebyshev method (van der Houwen and Sommeijer 1980; Verwer, Hundsdorfer and Sommeijer 1990, eq. 2.3 ff.,
// first order): s stages are stable to h tau w^2 = 1.07 s^2, all hinges push at once in each, so that momentum and
// angular momentum are kept. Implicit Euler with conjugate gradients asks for as many products, and in float for more:
// its residual is lost in rounding at w^2 ratios of 10^6. Velocities that lag positions by half a solver substep would
// pump modes whose phase returns with the substeps (trace of the map of a mode above 1 + P, P what damping leaves of
// its velocity): xpbd therefore damps between two half kicks. Links get the sweep alone: what they lose to it is below
// what XPBD takes from them anyway. Weak spot: the time is bounded by kMostStages (longest_damping), with a warning.
#include <algorithm>
#include <cmath>

#include "base/jobs.h"
#include "cloth/batches.h"

namespace feder {
namespace {
constexpr int kMostStages = 512;
constexpr std::uint32_t kDampGrain = 1024;  // vertices per job
}  // namespace

// Bound of w^2 of bending modes: sum k (g.v)^2 <= sum k W sum |v_i|^2/w_i over the vertices of each hinge, W = sum w
// |g|^2, so the largest sum of k W at a vertex bounds w^2, whatever the shape, as long as no hinge has more than at
// rest (kernel.h, damp_begin).
void ClothBatches::measure_hinges(const ClothView& v) {
  std::vector<double> sum(v.total, 0);
  for (const ClothHinge& k : v.mesh->hinges) {
    const double rate = hinge_response(v, k.v) * static_cast<double>(k.stiffness);
    for (const std::uint32_t i : k.v) sum[i] += rate;
  }
  bending_ = 0;
  for (const double s : sum) bending_ = std::fmax(bending_, s);
  FEDER_ASSERT(bending_ >= 0);
  damping_.clear();
}

// Work arrays of the stages, made when they are first needed.
void ClothBatches::prepare_stages(const ClothView& v) {
  if (damping_.size() == hinges_.size()) return;
  damping_.resize(hinges_.size());
  for (std::size_t n = 0; n < hinges_.size(); ++n)
    for (int i = 0; i < kLanes; ++i) {
      const HingeBatch& b = hinges_[n];
      const std::uint32_t at[4] = {b.v[0][i], b.v[1][i], b.v[2][i], b.v[3][i]};
      damping_[n].max_response.v[i] = static_cast<Real>(hinge_response(v, at) / static_cast<double>(b.compliance.v[i]));
    }
  stage_.resize(v.total), last_stage_.resize(v.total), first_rate_.resize(v.total), pushes_.resize(v.total);
}

double ClothBatches::longest_damping(Real h) const {
  const double rate = bending_ * static_cast<double>(h);
  return rate > 0 ? DampingStages(kMostStages).stability_limit() / rate : double(kInfinity);
}

void ClothBatches::damp_links(const ClothView& v, Real h, StepContext& c) {
  ClothPass p = pass(v, h);
  p.damping_time = v.damping * h;
  run(kernels_->damp_links, link_colors_, p, c);
}

void ClothBatches::damp_hinges(const ClothView& v, Real h, StepContext& c) {
  if (damps_in_stages(v, h)) return run_stages(v, h, c);
  ClothPass p = pass(v, h);
  p.damping_time = v.damping * h;
  run(kernels_->damp_hinges, hinge_colors_, p, c);
}

void ClothBatches::run_stages(const ClothView& v, Real h, StepContext& c) {
  // linearise the hinges; beyond kMostStages the damping time is cut to what they carry
  const double z = stability(v, h);
  const int count = DampingStages::needed(z, kMostStages);
  DampingStages stages(count);
  prepare_stages(v);
  FEDER_ASSERT(pushes_.size() == v.total && stage_.size() == v.total && damping_.size() == hinges_.size());
  ClothPass p = pass(v, h);
  p.damping = damping_.data();
  p.damping_time = static_cast<Real>(double(v.damping) * double(h) * std::fmin(1, stages.stability_limit() / z));
  p.rates = &v.velocity->x, p.pushes = &pushes_[0].x;
  run(kernels_->damp_begin, hinge_colors_, p, c);
  // three-term recurrence: impulses of all hinges at the last stage's velocities, then the next stage by vertex
  for (int k = 0; k < count; ++k) {
    const DampingStage s = stages.next();
    c.jobs->for_blocks(v.total, kDampGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      std::fill(pushes_.begin() + first, pushes_.begin() + last, Row4{});
    });
    run(kernels_->damp_stage, hinge_colors_, p, c);
    p.rates = &stage_[0].x;
    const Real mu = static_cast<Real>(s.mu), nu = static_cast<Real>(s.nu), rate = static_cast<Real>(s.rate);
    c.jobs->for_blocks(v.total, kDampGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3 push = v.delta_position[i].w * pushes_[i].vec();
        if (k == 0) {
          first_rate_[i].set(push), last_stage_[i] = Row4{}, stage_[i].set(rate * push);
          continue;
        }
        const Vec3 now = stage_[i].vec();
        stage_[i].set(mu * now + nu * last_stage_[i].vec() + rate * (first_rate_[i].vec() + push));
        last_stage_[i].set(now);
      }
    });
  }
  // the last stage is the change of the velocities
  c.jobs->for_blocks(v.total, kDampGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) v.velocity[i].add(stage_[i].vec());
  });
}

}  // namespace feder
