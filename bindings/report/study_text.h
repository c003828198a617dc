// A study as text: points.csv, report.json and the tables of the terminal; and back from JSON, for merging shards.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "feder/study.h"
#include "report/json.h"
#include "report/machine.h"
#include "report/table.h"

namespace feder::report {

// How a study was asked for: what the page names besides the numbers.
struct StudyContext : RunContext {
  std::vector<std::string> settings;  // options that differ from their default, "substeps = 8"
  std::vector<std::string> errors;    // norms, the plotted one first; empty: what points are ranked by
  std::vector<std::string> axes = {"time", "force"};
  Json gate = Json::object();  // filled by the gate
};

// An error norm by its short name: "end", "traj", "max", "energy", "drift", "momentum", "angular", "constraint",
// "event", "orient", "horizon". Null when unknown.
struct ErrorNorm {
  const char* name;
  const char* column;  // of points.csv, or of report.json alone
  const char* label;   // of an axis
  double StudyPoint::*value;
  bool more_is_better = false;  // then the axis is linear
  // Does the library rank points by it (fronts, fits, floors)?
  bool ranks(const ProblemInfo& problem) const;
};
const ErrorNorm* find_norm(const std::string& name);
std::vector<std::string> norm_names();

std::string settings_text(const Settings& settings);    // "angle=20; mu=0.3"
std::string listed_settings(const Settings& settings);  // ", angle = 20, mu = 0.3"
std::string csv_cell(const Settings& settings);
std::string csv_header();
// `problem` as the row names it. The row without what all points of a study have in common; the whole row.
std::string csv_measured(const std::string& problem, const StudyPoint& p);
std::string csv_row(const std::string& problem, const StudyResult& r, const StudyPoint& p);
// `labelled`: problems are named with the parameters that differ from their defaults.
std::string points_csv(std::span<const StudyResult> results, bool labelled = false);
inline std::string points_csv(const StudyResult& r) { return points_csv({&r, 1}); }

Json study_json(const StudyResult& r, const StudyContext& context);
// The result that study_json wrote. std::runtime_error "what is missing".
StudyResult study_from_json(const Json& json);

// Curves are drawn, not computed with: 6 digits of them are kept, in reports and before they are drawn, so that shards
// put together draw what the whole does.
void round_series(StudyResult& r);

// A point as it is kept while a study runs, with what the problem knew of itself by then; and back.
Json finished_json(const FinishedPoint& point, const ProblemInfo& problem);
FinishedPoint finished_from_json(const Json& json, ProblemInfo& problem);

// The value of a parameter for a reader: "1e8" for 1e+08.
std::string value_text(const std::string& value);
// "oscillator (stiffness = 100)": the parameters that differ from their defaults.
std::string problem_label(const ProblemInfo& problem);
// A label as the name of a file: letters, digits, '.', '-' and '_' stay.
std::string file_name(const std::string& label);

// "h = 0.01 s", "tol = 1e-6", with iterations and substeps where the rung sets them.
std::string rung_text(const StudyPoint& p);

// "published digits, 8 digits": what kind of reference, and how good.
std::string reference_text(const ReferenceInfo& reference);

// One row of the decision table: the cheapest method to an error.
struct Decision {
  double target = 0;
  bool reached = false;
  CostToAccuracy by_time, by_work;  // methods empty when nobody is known
  std::string verdict;
};
std::string target_text(double target);  // "0.01", "1e-4"
// Targets from 1e-1 down, ending with the first one that no method reaches.
std::vector<Decision> decisions(const StudyResult& r);

// ok or slow; the others failed.
bool succeeded(const StudyPoint& p);

// "By time" columns make sense only when there was a timing pass.
bool has_times(const StudyResult& r);

// How an output writes the cells of the decision table: the terminal and Markdown with less room, in ASCII.
struct DecisionFormat {
  const char *none, *equals, *step_unit, *microseconds;
  const char *force_evals, *least_time;  // columns
};
inline constexpr DecisionFormat kTerminal{"-", " ", "", " us", ">force evals", "least time"};
inline constexpr DecisionFormat kPaper{"–", " = ", " s", " µs", ">force evaluations", "least run time"};
Table decision_table(const StudyResult& r, const DecisionFormat& format);
std::string study_table(const StudyResult& r);
// What the terminal shows: the problem, the table, and the methods that failed.
std::string study_summary(const StudyResult& r, bool table_only);
// Methods with no point that is ok, with the reason: "explicit_euler: diverged at 0.12 s (12 of 12 rungs)".
std::vector<std::string> failed_methods(const StudyResult& r);
// Fitted orders that miss theory, one line each.
std::vector<std::string> off_orders(const StudyResult& r);
// A fragment of Markdown: the picture and the table.
std::string study_markdown(const StudyResult& r, const std::string& picture);

}  // namespace feder::report
