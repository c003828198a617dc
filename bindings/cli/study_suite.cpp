// The suites of `feder study --suite`: numerics.md 1.6 as rows. A row whose problem this build lacks is left out.
#include <fmt/format.h>

#include "cli/command.h"
#include "cli/study_parts.h"

namespace feder::cli {
namespace {

const std::vector<SuiteRow>& all_rows() {
  static const std::vector<SuiteRow> rows = {
      {"core", "oscillator", {"stiffness=100"}, {}, {"steps:100..800:x2"}, {"explicit_euler"}},
  };
  return rows;
}

bool known(const char* problem) {
  for (const auto& row : study_problems())
    if (std::string(row.name) == problem) return true;
  return false;
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
  bool any = false;
  for (const SuiteRow& row : all_rows()) {
    if (row.suite != suite) continue;
    any = true;
    if (known(row.problem)) out.push_back(row);
  }
  if (!any) throw Failure(kUsage, fmt::format("feder study: unknown suite '{}'; known: {}", suite, suite_names()));
  return out;
}

}  // namespace feder::cli
