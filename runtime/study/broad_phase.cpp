// Broad phases on a gas of boxes that fly about in a room and turn back at its walls: all answers are the same, so what
// differs is the time of a step. The ladder varies how far a box goes in a step, in shares of its size: where that is
// little, what is kept between steps pays. err_end is the share of pairs that do not overlap, err_constraint the share
// of those missed (there must be none of either). By box and step: force_evals are nodes and cells looked at, jac_evals
// boxes compared, rejected ends that changed places in `sweep_prune`. The truth: all pairs.
// Source: Ericson, "Real-Time Collision Detection" (2005), 7. Does not show: piles and planes.
#include "broad/broad_phase.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "base/rng.h"
#include "study/options.h"

namespace feder {
namespace {

constexpr int kBroadSteps = 32;

class BroadPhaseProblem final : public StudyProblem {
 public:
  explicit BroadPhaseProblem(const Params& given) {
    ProblemOptions o(given, info_);
    const int count = o.integer("boxes", 1000, 2, 100000, "cubes; the largest are 1 m wide");
    const double ratio = o.number("ratio", 1, 1, 1e9, "largest over smallest size");
    const double crowd = o.number("crowd", 0.25, 1e-3, 10, "boxes per cubic metre");
    const double resting = o.number("resting", 0, 0, 1, "share of the boxes that lie still");
    info_.family = "collision", info_.own_measure = true, info_.dense = false;
    info_.t_end = 1, info_.dof = 3 * count;
    room_ = std::cbrt(count / crowd);
    info_.x_scale = room_, info_.v_scale = 1;
    Rng rng(41);
    for (int i = 0; i < count; ++i) {
      const double z = rng.unit(), y = rng.unit(), x = rng.unit(), w = rng.unit(), v = rng.unit(), u = rng.unit();
      starts_.push_back({room_ * x, room_ * y, room_ * z}), ways_.push_back({2 * u - 1, 2 * v - 1, 2 * w - 1});
      sizes_.push_back(std::pow(ratio, -rng.unit()));
      motion_.push_back(rng.unit() < resting ? BoxMotion::still : BoxMotion::moving);
    }
    set_reference(ReferenceKind::quad, 15, 1e-7, "all pairs of boxes, compared one by one");
  }

  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all;
    for (const auto& kind : broad_phases()) all.push_back({kind.name, kind.summary});
    return all;
  }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override {
    std::vector<RunSpec> all;
    for (const char* speed : {"1", "0.3", "0.03", "0.003"}) {
      RunSpec spec;
      spec.method = method.name, spec.steps = kBroadSteps, spec.settings = {{"speed", speed}};
      all.push_back(spec);
    }
    return all;
  }
  void reference(double, Observation& out) const override {  // where the boxes start: they go where they are put
    out = {};
    for (const std::array<double, 3>& at : starts_)
      for (const double x : at) out.x.push_back(x), out.v.push_back(0);
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;

  // Boxes after so many steps.
  void place(double speed, int step, std::vector<Aabb>& out) const {
    out.resize(starts_.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      Vec3 at;
      for (std::size_t k = 0; k < 3; ++k) {
        const double go = motion_[i] == BoxMotion::still ? 0 : speed * sizes_[i] * ways_[i][k] * step;
        const double x = std::fabs(std::remainder(starts_[i][k] + go, 2 * room_));  // to and fro between the walls
        at[static_cast<int>(k)] = static_cast<Real>(x);
      }
      const Vec3 half = Vec3::Constant(static_cast<Real>(0.5 * sizes_[i]));
      out[i] = {at - half, at + half};
    }
  }
  std::span<const BoxMotion> motion() const { return motion_; }
  const std::vector<IndexPair>& truth(double speed, int step) const {
    for (const Known& k : known_)
      if (k.speed == speed && k.step == step) return k.pairs;
    std::vector<Aabb> boxes;
    place(speed, step, boxes);
    std::vector<IndexPair> pairs;
    for (std::uint32_t a = 0; a < boxes.size(); ++a)
      for (std::uint32_t b = a + 1; b < boxes.size(); ++b)
        if (overlaps(boxes[a], boxes[b]) && (motion_[a] == BoxMotion::moving || motion_[b] == BoxMotion::moving))
          pairs.push_back({a, b});
    return known_.emplace_back(Known{speed, step, std::move(pairs)}).pairs;
  }

 private:
  struct Known {
    double speed;
    int step;
    std::vector<IndexPair> pairs;
  };
  double room_ = 1;  // m
  std::vector<std::array<double, 3>> starts_, ways_;
  std::vector<double> sizes_;
  std::vector<BoxMotion> motion_;
  mutable std::vector<Known> known_;
};

class BroadPhaseRun final : public StudyRun {
 public:
  BroadPhaseRun(const BroadPhaseProblem& problem, const RunSpec& spec)
      : problem_(problem), h_(problem.info().t_end / spec.steps) {
    for (const auto& [name, value] : spec.settings)
      if (name == "speed") std::from_chars(value.data(), value.data() + value.size(), speed_);
    broad_ = find_variant(broad_phases(), spec.method, "broad phase").make(arena_, Params());
    boxes_.resize(static_cast<std::size_t>(spec.steps) + 1);  // all of them now, so that no step has to place them
    for (int k = 0; k <= spec.steps; ++k) problem.place(speed_, k, boxes_[static_cast<std::size_t>(k)]);
    for (std::uint32_t i = 0; i < boxes_[0].size(); ++i) touched_.push_back(i);
    broad_->find_pairs(boxes_[0], problem.motion(), touched_, pairs_, jobs_);
    std::erase_if(touched_, [&](std::uint32_t i) { return problem.motion()[i] == BoxMotion::still; });
  }
  void step() override {
    ++count_.steps;
    const std::vector<Aabb>& now = boxes_[static_cast<std::size_t>(count_.steps)];
    broad_->find_pairs(now, problem_.motion(), touched_, pairs_, jobs_);
    found_ += pairs_.size(), counts_.push_back(pairs_.size());
  }
  void observe(Observation& out) override { problem_.reference(h_ * static_cast<double>(count_.steps), out); }
  Invariants invariants() override {  // not timed
    Invariants i;
    if (count_.steps == 0) return i;
    const BroadWork w = broad_->work();
    work_.visits += w.visits, work_.tests += w.tests, work_.swaps += w.swaps, ++counted_;
    const auto each = [&](std::uint64_t n) { return static_cast<std::int64_t>(n / (counted_ * boxes_[0].size())); };
    count_.force_evals = each(work_.visits), count_.jac_evals = each(work_.tests), count_.rejected = each(work_.swaps);
    const std::vector<IndexPair>& truth = problem_.truth(speed_, static_cast<int>(count_.steps));
    std::size_t missed = 0;
    for (const IndexPair& p : truth) missed += !std::binary_search(pairs_.begin(), pairs_.end(), p);
    i.constraint = truth.empty() ? 0 : static_cast<double>(missed) / static_cast<double>(truth.size());
    return i;
  }
  StudyCounters counters() const override { return count_; }
  std::size_t bytes() const override { return arena_.bytes(); }
  bool measures_itself() const override { return true; }
  double own_error() const override {
    std::size_t extra = 0;
    for (std::size_t k = 0; k < counts_.size(); ++k) {
      const std::size_t touching = problem_.truth(speed_, static_cast<int>(k) + 1).size();
      extra += counts_[k] > touching ? counts_[k] - touching : touching - counts_[k];
    }
    return found_ == 0 ? 0 : static_cast<double>(extra) / static_cast<double>(found_);
  }

 private:
  const BroadPhaseProblem& problem_;
  double h_, speed_ = 0;
  Arena arena_{"broad"};
  JobPool jobs_{1};
  std::unique_ptr<BroadPhase> broad_;
  std::vector<std::vector<Aabb>> boxes_;  // by step
  std::vector<std::uint32_t> touched_;
  Array<IndexPair> pairs_{&arena_};
  std::size_t found_ = 0;
  BroadWork work_;                   // of the steps that were looked at
  std::uint64_t counted_ = 0;        // these
  std::vector<std::size_t> counts_;  // by step
  StudyCounters count_;
};

std::unique_ptr<StudyRun> BroadPhaseProblem::start(const RunSpec& spec) const {
  return std::make_unique<BroadPhaseRun>(*this, spec);
}

}  // namespace

Variant<StudyProblem> study_broad_phase() {
  return variant_of<StudyProblem, BroadPhaseProblem>("broad_phase", "a gas of boxes, its pairs by every broad phase");
}

}  // namespace feder
