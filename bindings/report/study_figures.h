// The figures of a study, as SVG text.
#pragma once
#include <string>
#include <vector>

#include "report/study_text.h"

namespace feder::report {

struct Figure {
  std::string file;     // "error_vs_time.svg"
  std::string caption;  // plain words
  std::string svg;      // a file of its own
  std::string inline_svg;
};

// Those that have data: error_vs_time.svg, error_vs_work.svg, order.svg, invariants.svg, and one
// error_vs_work_<norm>.svg for each further norm.
std::vector<Figure> study_figures(const StudyResult& r, const StudyContext& context);

// The norm that is plotted: the first of the context's that any point has.
const ErrorNorm& plotted_norm(const StudyResult& r, const StudyContext& context);

// The curves over time that are drawn: of each method the run whose work is nearest to the median of all runs.
std::vector<const StudySeries*> drawn_series(const StudyResult& r);

}  // namespace feder::report
