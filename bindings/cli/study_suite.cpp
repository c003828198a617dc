// The suites of `feder study --suite`: as rows. A row whose problem this build lacks is left out.
#include <algorithm>

#include "cli/command.h"
#include "cli/study_parts.h"

namespace feder::cli {
namespace {

const std::vector<SuiteRow>& all_rows() {
  static const std::vector<SuiteRow> rows = {
      // core: a line of each kind, in seconds; the baseline of tests/golden/study_core_*.csv
      {"core", "oscillator", {"stiffness=100"}, {}, {"steps:100..800:x2"}, {"explicit_euler"}},
      {"core", "oscillator", {"stiffness=1e4", "damping=2"}, {}, {"steps:100,400,1600"}, {"*"}},
      {"core", "kepler", {"e=0.6"}, {}, {"steps:400,1600,6400", "tol:1e-3,1e-5"}, {}},
      {"core", "pendulum", {}, {}, {"steps:80,320,1280", "tol:1e-3,1e-5"}, {}},
      {"core", "double_pendulum", {}, {}, {"steps:300,1200", "tol:1e-3,1e-5"}, {}},
      {"core", "prothero_robinson", {}, {}, {"steps:50,200", "tol:1e-3"}, {"*"}},
      {"core", "spring_pendulum", {}, {}, {"steps:60,600,6000", "tol:1e-3,1e-5"}, {"*"}},
      {"core", "chain", {}, {}, {"steps:32,128,512", "tol:1e-3,1e-5"}, {"*"}},
      {"core", "membrane", {"points=5"}, {}, {"steps:32,128", "tol:1e-3"}, {"*"}},
      {"core", "two_masses", {}, {}, {"steps:540,5400", "tol:1e-3"}, {"*"}},
      {"core", "swinging_chain", {}, {}, {"steps:60,600,6000", "tol:1e-3"}, {"*"}},
      {"core", "free_top", {}, {}, {"steps:800,3200"}, {}},
      {"core", "heavy_top", {}, {}, {"steps:240,960"}, {}},
      {"core", "bouncing_ball", {}, {}, {"steps:60,240"}, {}},
      {"core", "incline", {}, {}, {"steps:60,240"}, {}},
      {"core", "incline", {"mu=0.6"}, {}, {"steps:60,240"}, {}},
      {"core", "slide_to_rest", {}, {}, {"steps:60,240"}, {}},
      {"core", "rolling", {}, {}, {"steps:60,240"}, {}},
      {"core", "stack", {"boxes=5", "t_end=2"}, {}, {"steps:60,120"}, {}},
      {"core", "bullet", {}, {}, {"steps:10,40"}, {}},
      // smooth: where the order decides
      {"smooth", "oscillator", {}, {}, {}, {"*"}},
      {"smooth", "kepler", {"e=0.6"}, {}, {}, {"*"}},
      {"smooth", "kepler", {"e=0.9"}, {}, {}, {"*"}},
      {"smooth", "pendulum", {}, {}, {}, {"*"}},
      {"smooth", "pendulum", {"theta0=3.12413936106985"}, {}, {}, {"*"}},
      {"smooth", "double_pendulum", {}, {}, {}, {"*"}},
      {"smooth", "free_top", {}, {}, {}, {}},
      {"smooth", "heavy_top", {}, {}, {}, {}},
      // stiff: where stability decides; explicit methods fail and that is shown
      {"stiff", "oscillator", {"stiffness=1e6"}, {}, {}, {"*"}},
      {"stiff", "oscillator", {"stiffness=100", "damping=101"}, {}, {}, {"*"}},
      {"stiff", "spring_pendulum", {"stiffness=1e6"}, {}, {}, {"*"}},
      {"stiff", "swinging_chain", {"stiffness=1e6"}, {}, {}, {"*"}},
      {"stiff", "swinging_chain", {"stiffness=1e8"}, {}, {}, {"*"}},
      {"stiff", "swinging_chain", {"stiffness=1e8", "ratio=1000"}, {}, {}, {"*"}},
      {"stiff", "hanging_chain", {}, {}, {}, {"*"}},
      {"stiff", "two_masses", {}, {}, {}, {"*"}},
      {"stiff", "prothero_robinson", {}, {}, {}, {"*"}},
      // contact: every rigid solver
      {"contact", "bouncing_ball", {"e=0"}, {}, {}, {}},
      {"contact", "bouncing_ball", {"e=0.5"}, {}, {}, {}},
      {"contact", "bouncing_ball", {"e=0.8"}, {}, {}, {}},
      {"contact", "bouncing_ball", {"e=1"}, {}, {}, {}},
      {"contact", "incline", {"mu=0.3"}, {}, {}, {}},
      {"contact", "incline", {"mu=0.5"}, {}, {}, {}},
      {"contact", "incline", {"mu=0.6"}, {}, {}, {}},
      {"contact", "slide_to_rest", {}, {}, {}, {}},
      {"contact", "rolling", {}, {}, {}, {}},
      {"contact", "stack", {"boxes=10"}, {}, {}, {}},
      {"contact", "bullet", {}, {}, {}, {}},
  };
  return rows;
}

}  // namespace

std::string suite_names() {
  std::string out, last;
  for (const SuiteRow& row : all_rows())
    if (row.suite != last) out += (out.empty() ? "" : ", ") + (last = row.suite);
  return out;
}

std::vector<SuiteRow> suite_rows(const std::string& suite) {
  std::vector<SuiteRow> out;
  const std::vector<std::string> known = problem_names();
  bool any = false;
  for (const SuiteRow& row : all_rows()) {
    if (row.suite != suite) continue;
    any = true;
    if (std::ranges::find(known, row.problem) != known.end()) out.push_back(row);
  }
  if (!any) throw Failure(kUsage, "feder study: unknown suite '{}'; known: {}", suite, suite_names());
  return out;
}

}  // namespace feder::cli
