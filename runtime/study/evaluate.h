// From points to statements: fronts, orders, the cheapest way to an error. Pure functions of the points.
#pragma once
#include "study/result.h"

namespace feder {

// Fills fits, fronts (also the points' flags) and cost_to_accuracy.
void evaluate(StudyResult& result);

// The results of shards of one plan as one result, evaluated. SceneError when they do not belong together.
StudyResult merge_shards(std::vector<StudyResult> shards);

// The error a point is ranked by: err_end; of chaotic problems the share of t_end beyond the horizon.
double ranking_error(const ProblemInfo& problem, const StudyPoint& point);

}  // namespace feder
