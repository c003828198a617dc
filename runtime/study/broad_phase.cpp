// Broad phases on boxes that fly about in a room and turn back at its walls, in seven arrangements, or on those that a
// world had: all answers are the same, so what differs is the time of a step. The ladder varies how far a box goes in a
// step, in shares of its size, or how many steps of the world are left out: where that is little, what is kept between
// steps pays. err_end is the share of pairs that do not overlap, err_constraint the share of those missed (there must
// be none of either). By box and step: force_evals are nodes and cells looked at, jac_evals boxes compared, rejected
// ends that changed places in `sweep_prune`. The truth: all pairs. Source: Ericson, "Real-Time Collision Detection"
// (2005), 7. Does not show: planes.
#include "study/broad_phase.h"

#include <algorithm>
#include <charconv>

#include "study/moving_boxes.h"
#include "study/options.h"

namespace feder {
namespace {

constexpr int kBroadSteps = 32;

// The boxes of a problem: step 0 is the start.
class BoxSource {
 public:
  virtual ~BoxSource() = default;
  virtual BoxRecording::Frame at(double rung, int step) const = 0;
};

class MadeBoxes final : public BoxSource {
 public:
  MadeBoxes(std::string_view arrangement, std::uint32_t count, const MovingBoxes::Options& o)
      : boxes_(arrangement, count, o) {}
  BoxRecording::Frame at(double speed, int step) const override {
    BoxRecording::Frame f;
    for (std::uint32_t i = 0; i < boxes_.count(); ++i) {
      f.boxes.push_back(boxes_.box(i, speed, step));
      f.motion.push_back(boxes_.moves(i) ? BoxMotion::moving : BoxMotion::still);
    }
    return f;
  }

 private:
  MovingBoxes boxes_;
};

class RecordedBoxes final : public BoxSource {
 public:
  explicit RecordedBoxes(std::vector<BoxRecording::Frame> frames) : frames_(std::move(frames)) {}
  BoxRecording::Frame at(double stride, int step) const override {
    return frames_[std::min(frames_.size() - 1, static_cast<std::size_t>(step) * static_cast<std::size_t>(stride))];
  }

 private:
  std::vector<BoxRecording::Frame> frames_;
};

class BroadPhaseProblem final : public StudyProblem {
 public:
  explicit BroadPhaseProblem(const Params& given) {
    ProblemOptions o(given, info_);
    const std::vector<std::string> known(std::begin(MovingBoxes::kArrangements), std::end(MovingBoxes::kArrangements));
    const std::string& arrangement = known[o.choice("arrangement", "gas", known, "how the boxes lie")];
    const int count = o.integer("boxes", 1000, 2, 100000, "the largest of a gas are 1 m wide");
    MovingBoxes::Options of;
    of.ratio = o.number("ratio", 1, 1, 1e9, "largest over smallest size");
    of.crowd = o.number("crowd", 0.25, 1e-3, 10, "boxes of a gas per cubic metre");
    of.resting = o.number("resting", 0, 0, 1, "share of the boxes that lie still");
    of.origin = o.number("origin", 0, 0, 1e6, "m, of the room along each axis");
    of.teleports = o.integer("teleports", 0, 0, 1000, "in each step one box of so many is elsewhere; 0: none");
    source_ = std::make_unique<MadeBoxes>(arrangement, static_cast<std::uint32_t>(count), of);
    rung_ = "speed", rungs_ = {"1", "0.3", "0.03", "0.003"}, steps_ = kBroadSteps;
    describe();
  }
  explicit BroadPhaseProblem(BoxRecording recording) {
    info_.name = "broad_phase", info_.summary = "the boxes of " + recording.of + ", their pairs by every broad phase";
    const auto given = static_cast<int>(recording.frames.size()) - 1;
    if (given < 1) throw SceneError("broad_phase: a recording needs two steps at least");
    source_ = std::make_unique<RecordedBoxes>(std::move(recording.frames));
    rung_ = "stride", steps_ = std::min(given, kBroadSteps);
    for (int stride = std::max(1, std::min(8, given / steps_)); stride >= 1; stride /= 2)
      rungs_.push_back(std::to_string(stride));
    describe();
  }

  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all;
    for (const auto& kind : broad_phases()) all.push_back({kind.name, kind.summary});
    return all;
  }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override {
    std::vector<RunSpec> all;
    for (const std::string& rung : rungs_) {
      RunSpec spec;
      spec.method = method.name, spec.steps = steps_, spec.settings = {{rung_, rung}};
      all.push_back(spec);
    }
    return all;
  }
  void reference(double, Observation& out) const override {  // where the boxes start: they go where they are put
    out = {};
    for (const Aabb& b : source_->at(1, 0).boxes)
      for (int k = 0; k < 3; ++k) out.x.push_back(static_cast<double>(b.lo[k])), out.v.push_back(0);
    for (double& x : out.x)
      if (!(std::fabs(x) < 1e15)) x = 0;  // of a plane
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;

  BoxRecording::Frame at(double rung, int step) const { return source_->at(rung, step); }
  double rung_of(const RunSpec& spec) const {
    double rung = 1;
    for (const auto& [name, value] : spec.settings)
      if (name == rung_) std::from_chars(value.data(), value.data() + value.size(), rung);
    return rung;
  }
  const std::vector<IndexPair>& truth(double rung, int step) const {
    for (const Known& k : known_)
      if (k.rung == rung && k.step == step) return k.pairs;
    const BoxRecording::Frame f = at(rung, step);
    std::vector<IndexPair> pairs;
    for (std::uint32_t a = 0; a < f.boxes.size(); ++a)
      for (std::uint32_t b = a + 1; b < f.boxes.size(); ++b) {
        if (f.motion[a] == BoxMotion::absent || f.motion[b] == BoxMotion::absent) continue;
        if (f.motion[a] != BoxMotion::moving && f.motion[b] != BoxMotion::moving) continue;
        if (overlaps(f.boxes[a], f.boxes[b])) pairs.push_back({a, b});
      }
    return known_.emplace_back(Known{rung, step, std::move(pairs)}).pairs;
  }

 private:
  struct Known {
    double rung;
    int step;
    std::vector<IndexPair> pairs;
  };
  void describe() {
    const BoxRecording::Frame start = at(1, 0);
    Aabb all;
    for (const Aabb& b : start.boxes)
      if ((b.hi - b.lo).allFinite()) all.include(b);
    info_.family = "collision", info_.own_measure = true, info_.dense = false;
    info_.t_end = 1, info_.dof = 3 * static_cast<int>(start.boxes.size()), info_.v_scale = 1;
    info_.x_scale = all.lo[0] <= all.hi[0] ? static_cast<double>(Vec3(all.hi - all.lo).maxCoeff()) : 1;
    set_reference(ReferenceKind::quad, 15, 1e-7, "all pairs of boxes, compared one by one");
  }
  std::unique_ptr<BoxSource> source_;
  std::string rung_;  // what the ladder varies
  std::vector<std::string> rungs_;
  int steps_ = kBroadSteps;
  mutable std::vector<Known> known_;
};

class BroadPhaseRun final : public StudyRun {
 public:
  BroadPhaseRun(const BroadPhaseProblem& problem, const RunSpec& spec)
      : problem_(problem), h_(problem.info().t_end / spec.steps), rung_(problem.rung_of(spec)) {
    broad_ = find_variant(broad_phases(), spec.method, "broad phase").make(arena_, Params());
    for (int k = 0; k <= spec.steps; ++k) {  // all of them now, so that no step has to place them
      frames_.push_back(problem.at(rung_, k)), touched_.emplace_back();
      const BoxRecording::Frame& now = frames_.back();
      for (std::uint32_t i = 0; i < now.boxes.size(); ++i)
        if (k == 0 || now.motion[i] == BoxMotion::moving || changed(frames_[frames_.size() - 2], now, i))
          touched_.back().push_back(i);
    }
    find();
  }
  void step() override {
    ++count_.steps;
    find();
    found_ += pairs_.size(), counts_.push_back(pairs_.size());
  }
  void observe(Observation& out) override { problem_.reference(h_ * static_cast<double>(count_.steps), out); }
  Invariants invariants() override {  // not timed
    Invariants i;
    if (count_.steps == 0) return i;
    const BroadWork w = broad_->work();
    work_.visits += w.visits, work_.tests += w.tests, work_.swaps += w.swaps, ++counted_;
    const auto each = [&](std::uint64_t n) {
      return static_cast<std::int64_t>(n / (counted_ * frames_[0].boxes.size()));
    };
    count_.force_evals = each(work_.visits), count_.jac_evals = each(work_.tests), count_.rejected = each(work_.swaps);
    const std::vector<IndexPair>& truth = problem_.truth(rung_, static_cast<int>(count_.steps));
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
      const std::size_t touching = problem_.truth(rung_, static_cast<int>(k) + 1).size();
      extra += counts_[k] > touching ? counts_[k] - touching : touching - counts_[k];
    }
    return found_ == 0 ? 0 : static_cast<double>(extra) / static_cast<double>(found_);
  }

 private:
  static bool changed(const BoxRecording::Frame& before, const BoxRecording::Frame& now, std::uint32_t i) {
    return i >= before.boxes.size() || before.motion[i] != now.motion[i] || before.boxes[i].lo != now.boxes[i].lo ||
           before.boxes[i].hi != now.boxes[i].hi;
  }
  void find() {
    const auto k = static_cast<std::size_t>(count_.steps);
    broad_->find_pairs(frames_[k].boxes, frames_[k].motion, touched_[k], pairs_, jobs_);
  }
  const BroadPhaseProblem& problem_;
  double h_, rung_;
  Arena arena_{"broad"};
  JobPool jobs_{1};
  std::unique_ptr<BroadPhase> broad_;
  std::vector<BoxRecording::Frame> frames_;          // by step
  std::vector<std::vector<std::uint32_t>> touched_;  // likewise
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

std::unique_ptr<StudyProblem> broad_phase_study(BoxRecording recording) {
  return std::make_unique<BroadPhaseProblem>(std::move(recording));
}

Variant<StudyProblem> study_broad_phase() {
  return variant_of<StudyProblem, BroadPhaseProblem>("broad_phase", "moving boxes, their pairs by every broad phase");
}

}  // namespace feder
