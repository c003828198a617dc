// A sweep: every method of a problem up its ladder. First the error pass, point by point; then the timing pass on the
// points that reached the end, interleaved. A plan gives each point an index that does not depend on
// the shard that runs it, so results of shards merge to the whole.
#pragma once
#include <functional>
#include <optional>

#include "study/problem.h"
#include "study/run.h"

namespace feder {

struct TimingOptions {
  bool enabled = true;
  int warm_ups = 2, min_repeats = 5, max_repeats = 50;
  double min_total_s = 0.3;   // per point, unless max_repeats came first
  double budget_s = 25;       // for the whole sweep; every point is timed once whatever it says
  double noisy_ratio = 1.15;  // of median to minimum
};

struct Ladder {
  std::string axis;  // "h", "tol", "iters", "substeps", "steps"
  std::vector<double> values;
};

// A point of the error pass and its curves.
struct FinishedPoint {
  StudyPoint point;
  StudySeries series;
};

struct SweepOptions {
  std::vector<std::string> methods;  // empty: all
  std::vector<Ladder> ladders;       // empty: the problem's own; several axes: all combinations
  RunLimits limits;
  TimingOptions timing;
  WorkWeights weights;
  int shard = 0, shards = 1;  // points with index % shards == shard
  std::string machine;        // written into each point that is run here
  // Points of the same study that ran before it was stopped: taken over instead of run. Timed anew with the others.
  std::vector<FinishedPoint> done;
  // The problem as the last of them knew it (references of scenes are learned in runs); used when nothing is left to
  // run.
  std::optional<ProblemInfo> learned;
  // Called with each point that was run, as soon as its errors are known; may be empty.
  std::function<void(const FinishedPoint&, const ProblemInfo&)> finished;
  // Called between points with what is done, from 0 to 1, and where; may be empty.
  std::function<void(double done, const std::string& where)> progress;
};

struct PlannedPoint {
  std::size_t index = 0;
  MethodInfo method;
  RunSpec spec;
};

// "h:1e-1..1e-5:x2", "tol:1e-2..1e-12:x10", "iters:1..256:x2", "steps:60,600,6000". SceneError says what is wrong.
Ladder parse_ladder(std::string_view text);

// All points, whatever the shard. SceneError on unknown methods or ladders no method can use.
std::vector<PlannedPoint> plan_sweep(const StudyProblem& problem, const SweepOptions& options);

// The points of the shard, run, timed and evaluated.
StudyResult run_sweep(const StudyProblem& problem, const SweepOptions& options);

// Seconds per run of the points that reached the end.
void time_points(const StudyProblem& problem, std::span<const PlannedPoint> plan, const SweepOptions& options,
                 std::vector<StudyPoint>& points);

}  // namespace feder
