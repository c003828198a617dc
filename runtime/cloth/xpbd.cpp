// XPBD cloth, position-based dynamics with compliance in solver substeps: predict, long links (long_links.h), one sweep
// over all links and hinges in colour order, velocities from displacements (Macklin, Mueller and Chentanez, "XPBD", MIG
// 2016, algorithm 1; Macklin et al., "Small Steps in Physics Simulation", SCA 2019). A multiplier lives through the
// iterations of a solver substep, so stiffness does not depend on their number. Soft hinges push as forces before the
// sweep, at the state it starts from, which leaves no error at rest; only hinges too stiff for that (h^2 w^2 above
// kSoftHinge) are swept like links. Those of cloth that is flat at rest are a constant quadratic form (bending.h). Soft
// hinges push once for a group of solver substeps, before the middle one: a drift, a kick and a drift (Tuckerman, Berne
// and Martyna 1992), so cloth carried by hinges is at rest at the group's ends, g H^2/8 above its true position for
// groups of H. Not in groups where cloth lies on cloth: shreds in a tangle have hinges that turn over within a group.
// Where max_substeps allows fewer solver substeps than the sheet needs, up to four sweeps make up for some. Kept
// between steps: batches of the mesh. Weak spot: one sweep carries forces across few rows; the strain that is left, 2 g
// n^2 h^2/L for n rows, sets the number of solver substeps (step.cpp), so light cloth stretches more than its material
// under heavy bodies that lie on it. What sweeps add of angular momentum step.cpp takes out.
#include <algorithm>
#include <cmath>

#include "base/jobs.h"
#include "cloth/batches.h"

namespace feder {
namespace {

constexpr double kBendShare = 0.1;  // h^2 k sum w |gradient|^2 that is wanted for the stiffest hinge
// h^2 sum k/m of a vertex of a cloth that tension holds: what kernel.h takes off is there
constexpr double kTautShare = 1.4;
constexpr double kSoftHinge = 0.12;      // largest value of it at which hinges push as forces
constexpr int kTogether = 9;             // solver substeps that one push of soft hinges may stand for, odd
constexpr Real kMostSweeps = 4;          // in place of solver substeps that max_substeps does not allow
constexpr JobGrain kGrain{1024, 4'000};  // vertices per job

class Xpbd final : public ClothSolver {
 public:
  Xpbd(Arena& a, const Params& p) : batches_(a, true), iterations_(p.integer({"iterations", "", {1, 1000}}, 1)) {
    batches_.pick(wide_kernels(p));
  }

  void prepare(const ClothView& v, StepContext& c) override {
    batches_.build(v);
    batches_.build_long(v);
    batches_.current_position(v, *c.jobs);
    if (version_ != v.version) version_ = v.version, stiffest_ = stiffest_hinge(v);
  }

  void advance(const ClothView& v, double t, Real h, StepContext& c) override {
    FEDER_ASSERT(version_ == v.version);
    // kick: soft hinges push at the state that the last solver substep left, which is exact at rest, unlike a sweep
    soft_ = stiffest_ * double(h) * double(h) <= kSoftHinge;
    const int now = static_cast<int>(std::lround((t - c.time - c.substep * double(c.h)) / double(h)));
    const int together = !soft_ ? 0 : v.crowded ? 1 : pushed_now(now, h, c);
    if (now == 0) pushed_ = false;
    if (together > 0) push_hinges(v, h * static_cast<Real>(together), c);
    // predict
    c.jobs->for_blocks(v.total, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        v.before[i] = {v.delta_position[i].x, v.delta_position[i].y, v.delta_position[i].z, 0};
        if (v.delta_position[i].w != 0) v.velocity[i].add(h * v.acceleration[i]);
        v.delta_position[i].add(h * v.velocity[i].vec());
      }
    });
    batches_.reach(v, h, c);
    // sweeps of the rows
    const int sweeps = std::max(iterations_, static_cast<int>(std::ceil(std::min(v.lacking, kMostSweeps))));
    for (int k = 0; k < sweeps; ++k) batches_.solve(v, h, !soft_, {k, sweeps}, c);
    batches_.tie(v, h, c);
  }

  void damp(const ClothView& v, Real h, StepContext& c) override {
    if (!(v.damping > 0)) return;
    batches_.damp_links(v, h, c);
    if (!soft_ || !batches_.damps_in_stages(v, h)) batches_.damp_hinges(v, h, c);
  }
  bool reaches() const override { return true; }
  double longest_damping(Real h) const override { return batches_.longest_damping(h); }
  void validate(const ClothView& v) const override { batches_.validate(v); }

  // Bending waves have to be resolved, whatever the load: hinges that are swept are too soft. So are links, of which a
  // sweep carries m/h^2 at most; that matters where tension gives cloth its shape and its waves.
  double wanted_substeps(const ClothView& v, Real h) const override {
    const double taut = v.taut ? stiffest_link(v) / kTautShare : 0;
    return std::sqrt(std::fmax(stiffest_hinge(v) / kBendShare, taut)) * static_cast<double>(h);
  }

 private:
  // Strong damping acts in the middle of the first push of the step, or of each substep where the whole step is more
  // than stages carry: velocities and positions belong to the same time there.
  void push_hinges(const ClothView& v, Real time, StepContext& c) {
    const bool whole = double(v.damping) <= batches_.longest_damping(c.dt);
    const bool damped = !pushed_ && v.damping > 0 && batches_.damps_in_stages(v, c.h) && (!whole || c.substep == 0);
    batches_.bend(v, damped ? time / 2 : time, c);
    if (damped) batches_.damp_hinges(v, whole ? c.dt : c.h, c), batches_.bend(v, time / 2, c);
    pushed_ = true;
  }
  // Number of solver substeps for which soft hinges push before this one; 0: not now. Groups are odd, so that they have
  // a middle.
  int pushed_now(int now, Real h, const StepContext& c) const {
    const int count = static_cast<int>(std::lround(c.h / h));
    const auto odd = [](int n) { return n - 1 + n % 2; };
    const double most = std::sqrt(kSoftHinge / std::fmax(stiffest_, 1e-30)) / double(h);
    const int full = odd(static_cast<int>(std::fmax(1, std::fmin(most, kTogether)))), rest = count - count % full;
    FEDER_ASSERT(full % 2 == 1 && now >= 0 && now < count);
    const int group = now < rest ? full : odd(count - rest);
    now = now < rest ? now % full : now - rest;
    if (now >= group) return 1;  // the one that is left over
    return now == group / 2 ? group : 0;
  }

  ClothBatches batches_;
  int iterations_;
  bool soft_ = false, pushed_ = false;  // hinges push as forces; they have done so in this substep
  std::uint64_t version_ = ~std::uint64_t(0);
  double stiffest_ = 0;  // 1/s^2
};

}  // namespace

Variant<ClothSolver> cloth_xpbd() {
  return {"xpbd", "solver substeps with compliance, coloured sweeps: stable at any stiffness",
          [](Arena& a, const Params& p) -> std::unique_ptr<ClothSolver> { return std::make_unique<Xpbd>(a, p); }};
}

}  // namespace feder
