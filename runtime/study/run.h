// The error pass of one point: run it, look at it, judge it.
#pragma once
#include "study/problem.h"

namespace feder {

struct RunLimits {
  double budget_work = 4e7;  // force evaluations times points; more: slow, and stopped
  bool series = true;        // keep the curves over time
};

// Fills everything of `point` but timing, fronts and index. Same spec, same bits.
void run_point(const StudyProblem& problem, const MethodInfo& method, const RunSpec& spec, const RunLimits& limits,
               const WorkWeights& weights, StudyPoint& point, StudySeries* series);

double work_of(const StudyCounters& count, const WorkWeights& weights);

}  // namespace feder
