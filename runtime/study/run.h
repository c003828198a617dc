// The error pass of one point, and what it costs; the timing pass.
#pragma once
#include "feder/study.h"

namespace feder {

// Fills everything of `point` but timing, fronts and index. Same spec, same bits; when it was stopped, not all is
// there.
void run_point(const StudyProblem& problem, const MethodInfo& method, const RunSpec& spec, const RunLimits& limits,
               const WorkWeights& weights, StudyPoint& point, StudySeries* series);

double work_of(const StudyCounters& count, const WorkWeights& weights);

// Seconds per run of the points that reached the end.
void time_points(const StudyProblem& problem, std::span<const PlannedPoint> plan, const SweepOptions& options,
                 std::vector<StudyPoint>& points);

}  // namespace feder
