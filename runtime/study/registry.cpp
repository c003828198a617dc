// The table of study problems, generated from the feder_variant(study ...) lines, and the words of the results.
#include <charconv>

#include "feder/memory.h"
#include "feder/study.h"

namespace feder {

using Row = Variant<StudyProblem>;
#include "study_declare.inc"

std::span<const Variant<StudyProblem>> study_problems() {
  static const std::initializer_list<Variant<StudyProblem>> table = {
#include "study_rows.inc"
  };
  return {table.begin(), table.size()};
}

std::unique_ptr<StudyProblem> make_study_problem(std::string_view name, const Params& options) {
  const Variant<StudyProblem>& row = find_variant(study_problems(), name, "study problem");
  Arena unused("study");
  auto problem = row.make(unused, options);
  options.check_all_read(row.name);
  problem->info_.name = row.name;
  problem->info_.summary = row.summary;
  return problem;
}

// Rounding the step size to Real once, by half a unit in the last place, shifts the clock of the run by that much.
void StudyProblem::set_reference(ReferenceKind kind, int digits, double uncertainty, std::string source) {
  const double unit = static_cast<double>(kEpsilon) / 2;
  const double rounding = unit * (1 + info_.v_scale * info_.t_end / info_.x_scale);
  info_.reference = {kind, digits, uncertainty, rounding, std::move(source)};
}

void set_option(Params& options, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0)
    throw SceneError("expected NAME=VALUE, got '" + std::string(assignment) + "'");
  std::string key(assignment.substr(0, equals));
  const std::string_view text = assignment.substr(equals + 1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size())
    options.set(std::move(key), number);
  else if (text == "true" || text == "false")
    options.set(std::move(key), text == "true");
  else
    options.set(std::move(key), std::string(text));
}

const char* name_of(ReferenceKind kind) {
  static const char* const names[] = {"closed", "quad", "published", "self"};
  return names[static_cast<int>(kind)];
}

const char* name_of(PointStatus status) {
  static const char* const names[] = {"ok", "diverged", "nan", "refused", "slow"};
  return names[static_cast<int>(status)];
}

}  // namespace feder
